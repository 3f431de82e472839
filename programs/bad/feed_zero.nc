; expect 3:1:feed-missing
F0
G1 X10
M2
