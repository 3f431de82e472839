; expect 2:12:spline-words
G5.1 X1 Y1 I1 F100
M2
