; expect 3:15:cycle-peck 4:15:cycle-peck
G0 Z5
G83 X1 Z-5 R2 Q0 F100
G73 X1 Z-5 R2 Q-1
M2
