"""What stays in force from block to block: modes, parameters, coordinate systems, the tool table, a machine's settings."""
