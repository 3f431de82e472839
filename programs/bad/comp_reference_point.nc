; expect 4:1:comp-refused 5:1:comp-refused
G10 L1 P1 R2
F100 G41 D1 G1 X10
G28
G53 G0 X5
G40 X30
M2
