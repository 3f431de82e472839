%
(Square of 50 mm with sharp corners.)
(Shows four right angles, rounded within the tolerance of G64 P.)
G21 G17 G90 G94 G64 P0.01
G1 X50 F6000
G1 Y50
G1 X0
G1 Y0
M30
%
