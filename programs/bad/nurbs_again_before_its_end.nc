; expect fanuc 4:1:nurbs-unfinished
G0 X0 Y0
G6.2 P2 K0 X0 Y0 F100
G6.2 P2 K0 X0 Y0
K0 X10
K1
K1
M30
