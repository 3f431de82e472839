; expect 2:5:syntax
G0 XNaN
M2
