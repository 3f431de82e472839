; expect 2:5:parameter-number
G0 X#1.5
M2
