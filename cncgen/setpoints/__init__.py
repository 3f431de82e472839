"""setpoints."""
