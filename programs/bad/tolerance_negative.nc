; expect 2:5:negative-tolerance
G64 P-0.1
M2
