"""ISO 14649 (parts 10, 11 and 111): from entities to the records of `cncgen.stepnc.model`."""

from cncgen.stepnc.iso14649.reader import Iso14649Reader

__all__ = ["Iso14649Reader"]
