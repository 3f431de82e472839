"""The codes, a module a concern, and the table that the interpreter and `cncgen codes` take them from."""
