; expect 2:1:pin-missing 3:1:pin-missing 4:1:pin-missing 5:1:pin-missing 6:5:not-whole 7:5:negative-number
M62
M64
M67 E0
M68 Q1
M62 P1.5
M63 P-1
M2
