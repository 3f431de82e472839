; expect 3:1:spline-plane
G18
G5.1 X1 Y1 I1 J1 F100
M2
