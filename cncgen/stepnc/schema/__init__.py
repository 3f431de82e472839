"""The entities of the schemas with their attributes, and the check of a file against them."""
