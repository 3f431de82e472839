; expect 2:3:syntax
G0 X1
M2
