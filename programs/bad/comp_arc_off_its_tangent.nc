; expect 10:1:comp-gouge
; The second arc begins 0.4 degrees off the tangent of the first: outside of it the tool sweeps more than programmed.
G20 G90 G17 F200
G0 X0 Y0
G42.1 D2
G1 X15 Y0
G91
G3 X-0.22332 Y1.47760 I-5 J0
G3 X-0.65941 Y1.34103 I-4.76622 J-1.51100
G90 G1 X0 Y0
G40 G0 X60
M2
