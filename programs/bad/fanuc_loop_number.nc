; expect fanuc 2:12:loop-number 3:1:loop-number
WHILE[1EQ1]DO7
END7
M30
