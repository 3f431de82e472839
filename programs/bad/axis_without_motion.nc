; expect linuxcnc 3:1:no-motion-mode
G21
X10 Y5
M2
