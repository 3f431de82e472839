; expect 2:1:oword-unmatched
o1 return [3]
M2
