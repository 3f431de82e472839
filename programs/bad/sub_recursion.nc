; expect 3:1:call-depth
o1 sub
o1 call
o1 endsub
o1 call
M2
