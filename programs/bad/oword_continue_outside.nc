; expect 3:1:oword-unmatched
G0 X1
o1 continue
o2 sub
o2 endsub
M2
