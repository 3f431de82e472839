; expect 2:1:oword-unmatched
o1 sub
G0 X1
M2
