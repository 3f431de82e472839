; expect linuxcnc 2:1:unknown-code
G68 X0 Y0 R10
M2
