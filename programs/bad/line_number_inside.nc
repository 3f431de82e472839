; expect 2:4:syntax
G0 N5 X1
M2
