; expect 2:1:parameter-read-only
#<_x>=1
M2
