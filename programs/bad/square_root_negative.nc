; expect 2:4:domain
G0 X[SQRT[-1]]
M2
