; expect 5:1:nurbs-knot
G6.2 P2 K0 X0 Y0 F100
K0 X5 Y5
K1
K0.5
M2
