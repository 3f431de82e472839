; expect 2:7:not-whole
G2 I5 P1.5 F100
M2
