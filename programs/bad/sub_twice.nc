; expect 4:1:oword-duplicate
o1 sub
o1 endsub
o1 sub
o1 endsub
M2
