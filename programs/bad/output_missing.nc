; expect 2:1:pin-missing
M62
M2
