"""`ild`: look-ahead dynamics-based interpolation (Tsai 2010; docs/ild.md). Modules in the order in which data passes them:

sharp_corners    the corners of curves, and the speeds at them (sections 5.2 and 5.3)
stretch          a chunk of the toolpath, cut at its joints and sharp corners; the speed at which the joint of two rows may be passed
open_stretches   the stretches of the look-ahead that are not planned for good yet
look_ahead       speeds at joints and jerk-limited profiles between them (kernel ``seven_phase``)
dynamics         lower speeds where the predicted contour error is above its bound (section 5.4)
strategy         runs all of this
"""
