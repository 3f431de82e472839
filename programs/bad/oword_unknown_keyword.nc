; expect 2:4:syntax
o1 perform
M2
