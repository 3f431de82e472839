; expect linuxcnc 2:1:unknown-code
M12
M2
