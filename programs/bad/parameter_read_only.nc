; expect 2:1:parameter-read-only
#5420=1
M2
