; expect 2:8:syntax
#1=[1+2
M2
