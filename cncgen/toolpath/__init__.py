"""The intermediate representation between readers and planner: a program as columns, one row for each motion or event.

`record` has `Program` and `Toolpath`, `reading` the options of reading; `building` collects rows, `slicing` cuts and joins them,
and `lines` turns curves into lines.
"""
