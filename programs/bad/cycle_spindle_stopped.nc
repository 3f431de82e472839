; expect 3:1:cycle-spindle 5:1:cycle-spindle
G0 Z5
G84 X1 Z-5 R2 F100
M3 S100
G74 X1 Z-5 R2
M2
