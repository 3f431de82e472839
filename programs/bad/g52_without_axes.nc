; expect 2:1:axis-missing
G52
M2
