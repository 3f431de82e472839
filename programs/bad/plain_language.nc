; expect 4:3:pole-missing 6:3:arc-sense 7:6:arc-sense 8:3:arc-radius 12:15:cycle-missing 13:4:unsupported-block 14:9:label-missing
0 BEGIN PGM BAD MM
1 L X+10 Y+0 F500
2 C X+0 Y+10 DR+
3 CC X+0 Y+0
4 C X+0 Y+10
5 CP IPA+90 DR-
6 CR X+40 Y+0 R+2 DR+
7 CP PA+90 DR+
8 L X+5
9 L X+5
10 L X+1 FMAX M99
11 CYCL DEF 27.0 CYLINDER SURFACE
12 CALL LBL 1
13 END PGM BAD MM
