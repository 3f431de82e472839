; expect 5:1:nurbs-points
F100
G5.2 X1 Y1 P1 L4
X2 Y2 P1
G5.3
M2
