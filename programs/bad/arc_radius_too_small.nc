; expect 3:8:arc-radius
G0 X0 Y0
G2 X10 R4 F100
M2
