"""Tuning: gains placed or searched, with the margins of the loops that they make."""
