; expect fanuc 3:1:nurbs-first-point
G0 X0 Y0
G6.2 P2 K0 F100
K0 X10
K1
K1
M30
