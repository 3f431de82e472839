; expect 2:4:repeated-word
G0 X1 X2
M2
