; expect 2:6:syntax
G0 X o1 call
M2
