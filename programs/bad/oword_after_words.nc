; expect 2:7:syntax
G0 X1 o1 if [1]
M2
