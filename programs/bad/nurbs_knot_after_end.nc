; expect 6:1:nurbs-closed
G6.2 P2 K0 X0 Y0 F100
K0 X5 Y5
K1
K1
K1
M2
