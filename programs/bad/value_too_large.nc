; expect 2:4:number-range
G0 X10000000000
M2
