"""The intermediate representation between readers and planner: a program as columns, one row for each motion or event.

`record` has `Program` and `Toolpath`, `reading` the options of reading; `building` collects rows, `slicing` cuts and joins them,
`lines` turns curves into lines, and `gate` finds numbers that planning cannot hold.
"""
