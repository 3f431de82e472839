; expect 3:11:cycle-depth
G0 Z5
G81 X1 Z5 R2 F100
M2
