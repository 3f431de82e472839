; expect 2:5:not-whole
G41 D1.5
M2
