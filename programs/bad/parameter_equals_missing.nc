; expect 2:5:syntax 3:4:syntax 4:2:syntax
#1 5
#2=
#=3
M2
