; expect 2:5:negative-number
G43 H-1
M2
