; expect 4:1:feed-missing
F100
G94
G1 X1
M2
