; expect 2:1:oword-arguments
o1 while [1] [2]
o1 endwhile
M2
