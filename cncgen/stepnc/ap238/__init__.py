"""The AIM of ISO 10303-238 (AP238): from its graph of properties to the records of `cncgen.stepnc.model`."""

from cncgen.stepnc.ap238.reader import Ap238Reader

__all__ = ["Ap238Reader"]
