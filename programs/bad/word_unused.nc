; expect 2:7:unused-word
G0 X1 Q2
M2
