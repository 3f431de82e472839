; expect 2:1:oword-unmatched
o1 if [0]
G0 X1
M2
