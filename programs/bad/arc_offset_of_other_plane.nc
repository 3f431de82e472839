; expect 3:11:arc-plane
G17
G2 X10 I5 K1 F100
M2
