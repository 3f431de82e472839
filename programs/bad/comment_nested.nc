; expect linuxcnc 2:7:nested-comment
G0 X1 (a (b) c)
M2
