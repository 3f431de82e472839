"""From text to blocks: the lanes of reading, expressions, comments, and which control a program is written for."""
