; expect linuxcnc 3:15:cycle-repeats 4:15:cycle-repeats
G0 Z5
G81 X1 Z-5 R2 L0 F100
G81 X1 Z-5 R2 L1.5
M2
