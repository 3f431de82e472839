; expect 4:1:too-many-steps
o1 repeat [100000000]
#1=1
o1 endrepeat
M2
