; expect 5:1:division-by-zero
o1 sub
G0 X#1
o1 endsub
o1 call [1/0]
o1 call [2]
M2
