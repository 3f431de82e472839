; expect 8:1:nurbs-equal-knots
G6.2 P2 K0 X0 Y0 F100
K0 X1 Y1
K0.5 X2 Y0
K0.5 X3 Y0
K0.5 X4 Y0
K1
K1
M2
