; expect linuxcnc 2:9:spline-order 8:7:nurbs-weight
G5.2 P1 L2.5 F100
X0 Y1 P1
X2 Y2 P1
X2 Y0 P1
G5.3
G5.2 P1 L3 X1 Y2
X3 Y0 P0
X4 Y2 P1
G5.3
M2
