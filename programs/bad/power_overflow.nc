; expect 2:4:number-range
G0 X[10**400]
M2
