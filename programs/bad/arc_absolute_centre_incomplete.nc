; expect 3:1:arc-centre
G90.1
G2 X10 I5 F100
M2
