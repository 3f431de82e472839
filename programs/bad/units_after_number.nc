; expect 2:8:syntax 3:7:syntax
G0 X10mm
G1 X1in F100
M2
