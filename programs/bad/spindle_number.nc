; expect 2:9:spindle-number
M3 S100 $9
M2
