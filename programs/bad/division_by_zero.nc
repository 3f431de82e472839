; expect 2:4:division-by-zero
G0 X[1/0]
M2
