"""stepnc."""
