; expect 2:6:probe-short 3:1:axis-missing 5:1:comp-refused
F100 G38.2 X0
G38.3
G41.1 D0 G1 X5
G38.2 X10
G40
M2
