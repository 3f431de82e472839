"""The intermediate representation: a program as columns, a row a motion or an event, and how programs are read."""
