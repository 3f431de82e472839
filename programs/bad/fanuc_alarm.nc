; expect fanuc 2:1:macro-alarm
#3000=7(CLAMP OPEN)
M30
