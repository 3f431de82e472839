; expect 6:5:unknown-parameter
o1 sub
#<here>=3
o1 endsub
o1 call
G0 X#<here>
M2
