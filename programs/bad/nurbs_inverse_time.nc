; expect 3:1:nurbs-mode
G93
G6.2 P2 K0 X0 Y0 F100
K0 X5 Y5
K1
K1
M2
