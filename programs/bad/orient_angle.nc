; expect 2:5:orient-angle
M19 R400
M2
