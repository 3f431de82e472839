; expect 3:4:domain
#1=2
G0 X[ASIN[#1]]
M2
