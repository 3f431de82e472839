; expect 3:1:g53-motion
G91
G53 G0 X1
M2
