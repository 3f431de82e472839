; expect 2:6:syntax
G1 X F100
M2
