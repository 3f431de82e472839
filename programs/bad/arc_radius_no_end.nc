; expect 2:1:arc-end
G2 Z5 R5 F100
M2
