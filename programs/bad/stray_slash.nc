; expect 2:7:syntax
G0 X1 /Y2
M2
