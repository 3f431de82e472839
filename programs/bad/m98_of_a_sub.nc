; expect 5:5:sub-kind
o5 sub
G0 X1
o5 endsub
M98 P5
M2
