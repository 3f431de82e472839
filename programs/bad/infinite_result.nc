; expect 3:4:number-range
#1=[EXP[700]*EXP[700]]
G0 X#1
M2
