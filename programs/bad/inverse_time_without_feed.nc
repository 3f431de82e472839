; expect 4:1:feed-missing
G93
G1 X1 F2
X2
M2
