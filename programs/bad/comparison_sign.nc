; expect 2:11:syntax 4:11:syntax
o1 if [#1 > 3]
o1 endif
o2 if [#1 = 3]
o2 endif
M2
