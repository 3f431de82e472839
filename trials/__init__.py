"""Randomised trials: what must hold of every program, tried on thousands that are drawn (README.md beside this file)."""
