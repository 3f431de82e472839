; expect 2:6:unused-word
G0 X1e+3
M2
