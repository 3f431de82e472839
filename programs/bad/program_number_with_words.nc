; expect 2:7:syntax
O0001 G0 X5
M2
