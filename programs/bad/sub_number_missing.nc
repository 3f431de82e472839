; expect 2:5:sub-missing
M98 P77
M2
