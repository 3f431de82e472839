; expect 2:6:syntax
#1=[2^3]
M2
