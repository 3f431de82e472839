%
(Pick and place path of a die bonder: two sharp corners of 90 degrees within one cubic NURBS.)
(Shows what a step at the start and a corner ask of the drives: plan it on die-bonder with --feedrate constant)
(--interpolator uniform, and --saturation off or reactive; docs/saturation.md.)
(START, X0 Y0)
G21 G17 G90 G94 G61
G6.2 P4 K0 X0 Y0 R1 F6000
K0 X12 Y0 R1
K0 X24 Y0 R1
K0 X30 Y0 R1
K0.0666666667 X30 Y0 R1
K0.133333333 X30 Y0 R1
K0.2 X30 Y4 R1
K0.266666667 X30 Y16 R1
K0.333333333 X30 Y20 R1
K0.4 X30 Y20 R1
K0.466666667 X30 Y20 R1
K0.533333333 X36 Y20 R1
K0.6 X46 Y20 R1
K0.666666667 X55 Y20 R1
K0.733333333 X59 Y20 R1
K0.8 X60 Y20 R1
K0.866666667 X60 Y20 R1
K0.933333333 X60 Y20 R1
K1
K1
K1
K1
M30
%
