; expect 2:1:negative-number
T-1
M2
