; expect 2:4:syntax
G0 Ä1
M2
