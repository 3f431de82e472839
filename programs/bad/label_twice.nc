; expect 4:1:oword-duplicate
o1 if [1]
o1 endif
o1 if [1]
o1 endif
M2
