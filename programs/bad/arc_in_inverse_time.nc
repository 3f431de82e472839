; expect 3:1:feed-missing 4:1:feed-missing
G93
G2 X10 I5
G1 X5
M2
