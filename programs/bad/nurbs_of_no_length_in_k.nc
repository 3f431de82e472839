; expect fanuc 6:1:nurbs-end-knots
G0 X0 Y0
G6.2 P2 K0 X0 Y0 F100
K0 X10
K0
K0
M30
