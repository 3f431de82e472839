; expect 3:9:axis-words-twice 4:1:cycle-words 5:1:unknown-code 6:1:pitch-missing 7:1:profile-missing
G50 S2000 (LATHE)
G0 X20. U2.
G75 Z-10. P1000
G91 X1.
G32 Z-5.
G70 P10
M30
