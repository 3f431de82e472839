; expect 2:1:spline-closed
G5.3
M2
