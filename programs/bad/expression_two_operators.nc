; expect 2:10:syntax
G0 X[1 * / 2]
M2
