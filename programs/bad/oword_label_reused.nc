; expect 5:1:oword-duplicate
o1 if [1]
G0 X1
o1 endif
o1 while [0]
o1 endwhile
M2
