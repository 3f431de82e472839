; expect fanuc 2:1:number-range 3:5:syntax 4:1:not-whole 5:15:syntax
GOTO #1
GOTO
GOTO 1.5
IF[#1EQ#0]GOTO
M30
