"""The order of execution: the program as a stream, loops, branches, subroutines and macros, and lines that run again."""
