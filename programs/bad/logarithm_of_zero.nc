; expect 2:4:domain
G0 X[LN[0]]
M2
