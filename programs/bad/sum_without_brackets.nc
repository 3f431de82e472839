; expect 2:9:syntax
G1 X-10.-5 F100
M2
