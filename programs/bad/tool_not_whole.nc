; expect 2:1:not-whole
T1.5
M2
