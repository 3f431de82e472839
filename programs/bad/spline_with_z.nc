; expect 2:12:spline-axes
G5.1 X1 Y1 Z1 I1 J1 F100
M2
