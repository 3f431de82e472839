; expect 2:1:sub-missing
M98 P77
M2
