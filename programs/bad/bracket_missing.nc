; expect 2:11:syntax
G1 X[#1+3 F100
M2
