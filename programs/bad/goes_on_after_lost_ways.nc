; expect 2:1:sub-missing 3:1:unknown-code 5:6:division-by-zero 6:3:division-by-zero 8:4:repeated-word 10:3:call-depth 13:1:unknown-code 14:5:sub-missing 16:1:unknown-code 18:1:unknown-code 19:1:sub-missing 20:1:oword-unmatched 21:1:oword-unmatched 22:13:syntax 23:1:oword-unmatched 24:1:oword-unmatched 25:1:oword-unmatched 28:1:sub-unfinished 29:4:repeated-word
o<nowhere> call
G999
o1 while [#1 lt 5]
  G1 X[1/0] F100
  #1=[#1+1/0]
o1 endwhile
G0 X1 X2
o2 sub
  o2 call
o2 endsub
o2 call
G998
M98 P77
o3 if [1]
G997
o4 while [1 eq 1]
G996
o5 call
o6 endif
o6 else
o7 repeat [3
o8 break
o9 return
o10 sub
G1 X1
o11 endsub
o10 call
G0 Y1 Y2
M2
