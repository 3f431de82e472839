; expect 2:4:syntax 3:1:oword-unmatched
o1 whlie [1]
o1 endwhile
M2
