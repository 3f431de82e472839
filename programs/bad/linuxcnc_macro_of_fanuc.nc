; expect linuxcnc 2:1:unsupported-flow
IF [#1 EQ 1] GOTO 10
N10 M2
