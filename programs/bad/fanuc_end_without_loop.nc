; expect fanuc 2:1:loop-unmatched
END2
M30
