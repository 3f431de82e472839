; expect fanuc 8:1:nurbs-points
G0 X0 Y0
G6.2 P4 K0 X0 Y0 F100
K0 X10
K0
K1
K1
K1
M30
