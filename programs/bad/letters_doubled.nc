; expect 2:2:syntax 3:5:syntax
GG0 X1
G0 XX1
M2
