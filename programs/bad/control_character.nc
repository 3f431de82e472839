; expect 2:6:syntax
G0 X1
G0 X2
M2
