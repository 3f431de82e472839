"""Executing the records of `cncgen.stepnc.model`: canonical machining functions, whatever listens to them."""
