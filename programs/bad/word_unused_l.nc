; expect 2:12:unused-word
G1 X1 F100 L3
M2
