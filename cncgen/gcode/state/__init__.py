"""The state that stays in force from block to block: modes, parameters, coordinate systems, tools, a machine's settings."""
