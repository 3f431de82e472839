; expect 4:1:too-many-steps
o1 repeat [1000000000]
#1=1
o1 endrepeat
M2
