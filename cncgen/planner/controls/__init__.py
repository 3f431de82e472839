"""Estimates of the time that other controls take: trapezoids of speed, with the rules of each for corners and look-ahead.

Only speeds are estimated. Positions stay on the programmed path, also where a control would round a corner.
"""
