; expect 6:1:nurbs-unfinished
G6.2 P3 K0 X0 Y0 F100
K0 X5 Y5
K0 X9 Y0
K1
G1 X5
M2
