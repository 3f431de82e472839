; expect 2:7:syntax
G0 X10,5 Y3
M2
