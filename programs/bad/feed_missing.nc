; expect 3:1:feed-missing
G21
G1 X10
M2
