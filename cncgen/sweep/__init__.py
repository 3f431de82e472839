"""Sweeps: programs × machines × varied keys, as jobs on the processes of one machine or of a cluster, with rows as results.

`definition` reads SWEEP.toml; `quantities` and `designs` give the values; `jobs` makes a job of each, and `figures`
computes one. `driver` hands jobs to `local_workers` or `cluster`, and `results` keeps their rows in Parquet. `sensitivities`
and `ranking` read them again. `optimisation` searches instead of drawing.
"""
