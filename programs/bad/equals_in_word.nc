; expect linuxcnc 2:5:syntax
G0 X=5
M2
