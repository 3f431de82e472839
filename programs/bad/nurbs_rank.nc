; expect 2:6:nurbs-rank
G6.2 P7 K0 X0 Y0 F100
K0 X5 Y5
M2
