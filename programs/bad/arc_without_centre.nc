; expect 2:1:arc-centre
G2 X10 F100
M2
