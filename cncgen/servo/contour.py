"""The true contour error: the distance of a position from the commanded path (`cncgen.geometry.contour_distance`)."""

from cncgen.geometry.contour_distance import (
    AHEAD,
    BEHIND,
    REACH,
    ContourTracker,
    contour_error,
    nearest_on_path,
)

__all__ = ["AHEAD", "BEHIND", "REACH", "ContourTracker", "contour_error", "nearest_on_path"]
