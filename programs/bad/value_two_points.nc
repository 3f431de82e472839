; expect 2:8:syntax
G0 X1.2.3
M2
