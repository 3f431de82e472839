; expect fanuc 2:5:dwell-time
G04 P-500
M30
