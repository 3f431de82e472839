"""The feedrates that the papers compare with: `constant`, `adaptive` and `curvature`, each a law of speed by curvature."""
