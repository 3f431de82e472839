; expect 2:7:arc-turns
G2 I5 P0 F100
M2
