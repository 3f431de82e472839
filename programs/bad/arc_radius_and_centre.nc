; expect 2:11:arc-centre
G2 X10 I5 R5 F100
M2
