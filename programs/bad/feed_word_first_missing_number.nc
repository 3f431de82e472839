; expect 2:2:syntax 3:1:feed-missing
F
G1 X1
M2
