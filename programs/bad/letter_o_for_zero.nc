; expect 2:6:syntax
G1 X1O F100
M2
