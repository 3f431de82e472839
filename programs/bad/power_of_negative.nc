; expect 2:4:domain
G0 X[[-2]**0.5]
M2
