; expect 2:1:unknown-code
G54.12
M2
