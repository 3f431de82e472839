"""Placements and curves of an exchange structure as matrices and pieces of a path."""
