; expect fanuc 2:16:syntax 4:1:loop-unmatched
WHILE [#1 LT 3]
#1=#1+1
END 1
M30
