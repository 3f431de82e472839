; expect 2:12:nurbs-first-point
G6.2 P2 K0 X1 Y0 F100
K0 X5 Y5
K1
K1
M2
