; expect fanuc 3:5:reference-point 4:1:axis-missing 5:1:reference-point
(G28 ALONE GOES HOME AS ON HAAS)
G30 P5 Z0
G30
G29 X5
M30
