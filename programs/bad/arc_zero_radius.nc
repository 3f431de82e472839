; expect 2:8:arc-zero-radius
G2 X10 I0 J0 F100
M2
