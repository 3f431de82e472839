; expect 2:5:negative-tolerance 3:10:negative-tolerance
G64 P-0.1
G64 P0.1 Q-1
M2
