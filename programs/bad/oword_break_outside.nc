; expect 3:1:oword-unmatched
G0 X1
o1 break
M2
