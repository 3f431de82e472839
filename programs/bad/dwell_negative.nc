; expect 2:4:dwell-time
G4 P-1
M2
