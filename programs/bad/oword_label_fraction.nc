; expect 3:1:oword-label 4:1:oword-label
#1=1.5
o[#1] if [1]
o[#1] endif
M2
