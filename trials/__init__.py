"""Randomised trials: properties of every program, tried on thousands that are drawn (README.md beside this file)."""
