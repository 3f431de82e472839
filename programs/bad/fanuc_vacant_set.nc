; expect fanuc 2:1:parameter-read-only
#0=1
M30
