; expect 2:5:parameter-number
G0 X#0
M2
