; expect 3:1:g53-motion
F100
G53 G2 X1 I0.5
M2
