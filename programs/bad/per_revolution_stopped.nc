; expect 3:1:spindle-stopped
G95 F0.1
G1 X1
M2
