; expect 2:1:unknown-code
G-1
M2
