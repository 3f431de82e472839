; expect 2:9:syntax
G1 X10 F
M2
