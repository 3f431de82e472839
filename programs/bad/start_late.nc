; expect 3:1:start-late
G0 X1
(START, X5)
M2
