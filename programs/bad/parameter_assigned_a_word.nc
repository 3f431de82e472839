; expect 2:4:syntax
#1=X5
M2
