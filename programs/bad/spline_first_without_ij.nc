; expect 2:1:spline-words
G5 X1 Y1 P0 Q-3 F100
M2
