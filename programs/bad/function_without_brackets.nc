; expect 2:8:syntax 3:10:syntax
#1=SIN 30
G0 X SQRT4
M2
