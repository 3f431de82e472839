; expect 3:4:syntax
; The letter is the sign of the kelvin, U+212A, of which small letters make a k.
G0 K1
M2
