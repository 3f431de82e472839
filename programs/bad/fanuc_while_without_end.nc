; expect fanuc 3:17:loop-unmatched
#1=0
WHILE [#1 LT 3] DO 2
#1=#1+1
M30
