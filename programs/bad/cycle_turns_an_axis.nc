; expect 3:8:cycle-rotary
G0 Z5
G81 X1 A30 Z-5 R2 F100
M2
