; expect linuxcnc 2:6:syntax
#1=#2+1
M2
