; expect 2:10:syntax 3:4:syntax
#1=SQRT[4,2]
#2=ATAN[1]
M2
