; expect 2:1:axis-missing
G92
M2
