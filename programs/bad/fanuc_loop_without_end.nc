; expect fanuc 3:13:loop-unmatched
#1=5
WHILE[#1LT3]DO1
M30
