; expect 2:7:syntax
G0 X1 ?
M2
