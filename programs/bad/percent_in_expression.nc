; expect 2:7:syntax
#1=[5 % 2]
M2
