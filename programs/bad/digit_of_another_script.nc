; expect 2:5:syntax
G0 X１
M2
