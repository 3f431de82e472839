; expect 2:11:syntax
G0 X1 (a) )
M2
