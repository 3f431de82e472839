; expect 2:7:syntax 3:4:syntax
#1=SINE[30]
#2=SQR[4]
M2
