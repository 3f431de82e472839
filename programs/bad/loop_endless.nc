; expect 4:1:too-many-steps
o1 while [1]
#1=[#1+1]
o1 endwhile
M2
