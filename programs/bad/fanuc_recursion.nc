; expect fanuc 6:1:call-depth
O1
M98 P2
M30
O2
M98 P2
M99
