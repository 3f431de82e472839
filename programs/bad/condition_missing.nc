; expect 2:1:oword-arguments
o1 if
o1 endif
M2
