; expect 4:10:arc-radius 5:4:arc-zero-radius
F100
G2 X10 Y0 I5 J1
G3 X0 Y5 I-4
G2 I0 J0
M2
