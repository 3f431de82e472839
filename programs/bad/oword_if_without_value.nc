; expect 2:1:oword-arguments
o1 if
G0 X1
o1 endif
M2
