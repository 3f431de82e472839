; expect 2:5:orient-angle 3:9:orient-way 4:9:orient-time
M19 R400
M19 R10 P3
M19 R10 Q0
M2
