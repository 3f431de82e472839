; expect fanuc 4:9:corner-next 6:6:corner-plane 8:7:corner-motion 9:9:corner-size 12:6:corner-size 13:5:corner-next
O1 (chamfers and roundings that cannot be)
G90 G17 F100
G1 X10. ,C5.
M3
X20. ,C5
Z5.
G0 X0 ,C3
G1 X10. ,R100.
Y10.
X20.
Y20. ,C-1.
X0. ,C5.
M30
