; expect fanuc 2:13:syntax 3:4:syntax 4:7:syntax
IF [#1 EQ 2]
IF #1 EQ 2 THEN #3=1
IF [#1=2] GOTO 10
N10 M30
