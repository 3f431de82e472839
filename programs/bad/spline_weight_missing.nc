; expect 4:1:nurbs-weight
F100
G5.2 X1 Y1 P1 L3
X2 Y2
G5.3
M2
