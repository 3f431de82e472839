"""Generators of random programs, machines and files, which trials and tests share."""
