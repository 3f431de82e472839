%
(Square of 50 mm with corners of radius 5 mm.)
(Shows tangent line-arc junctions, where the curvature jumps.)
(START, X5 Y0)
G21 G17 G90 G94 G64 P0.01
G0 X5 Y0
G1 X45 F6000
G3 X50 Y5 R5
G1 Y45
G3 X45 Y50 R5
G1 X5
G3 X0 Y45 R5
G1 Y5
G3 X5 Y0 R5
M30
%
