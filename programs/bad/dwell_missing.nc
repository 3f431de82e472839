; expect 2:1:dwell-time
G4
M2
