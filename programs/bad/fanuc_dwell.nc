; expect fanuc 2:1:dwell-time
G04
M30
