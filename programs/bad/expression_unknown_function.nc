; expect 2:9:syntax
G0 X[SINH[1]]
M2
