; expect 2:1:spline-words
G5 X1 Y1 I1 J1 F100
M2
