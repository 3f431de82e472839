; expect 3:6:unused-word
F100
G1 X1e400
M2
