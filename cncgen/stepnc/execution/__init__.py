"""Executing the records of `cncgen.stepnc.model`: canonical machining functions for any listener."""
