; expect 2:1:syntax
10 G0 X5
M2
