; expect 2:1:parameter-number
#9999=1
M2
