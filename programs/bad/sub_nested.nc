; expect 2:1:oword-nested-sub
o1 sub
o2 sub
o2 endsub
o1 endsub
M2
