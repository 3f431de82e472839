"""The turned features of the AIM (ISO 10303-238, 5.1.4, over ISO 10303-522)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cncgen.geometry import elementary
from cncgen.stepnc import turned_shapes
from cncgen.stepnc.ap238.graph import Item
from cncgen.stepnc.ap238.profiles import OPEN, Profiles, component_of, find, profile_of
from cncgen.stepnc.ap238.shapes import Component, Shapes
from cncgen.stepnc.entities import Entity
from cncgen.stepnc.geometry import profile_shapes
from cncgen.stepnc.geometry.frames import Matrix
from cncgen.stepnc.geometry.pieces import Piece
from cncgen.stepnc.model import Shape

#: Their entities; `kind` tells them apart further.
ENTITIES = ("OUTER_ROUND", "REVOLVED_PROFILE", "THREAD", "EXTERNALLY_DEFINED_FEATURE_DEFINITION")
_GROOVES = ("SQUARE_U_PROFILE", "ROUNDED_U_PROFILE", "VEE_PROFILE", "TEE_PROFILE")
#: A number of threads that makes a finer pitch, mm, is one an inch.
FINEST = 0.2
INCH = 25.4


class TurnedProfiles:
    """Reads turned features."""

    def __init__(self, shapes: Shapes, profiles: Profiles) -> None:
        self.shapes = shapes
        self.profiles = profiles

    def kind(self, entity: Entity, keyword: str) -> str:
        """Return the kind of a feature: ``outer diameter``, ``groove``, ``revolved flat``, ``thread``, ``straight knurl``…"""
        part = entity.instance.part("CHARACTERIZED_OBJECT")
        words = str(part.parameters[-1] or "").strip().lower() if part and part.parameters else ""
        if keyword == "OUTER_ROUND":
            return words or "outer diameter"
        if keyword == "THREAD" or "thread" in words:
            return "thread"
        if keyword != "REVOLVED_PROFILE":
            return words or "knurl"
        profile = profile_of(self.shapes.components(entity.id), OPEN)
        if "groove" in words or (profile is not None and profile.keyword in _GROOVES):
            return "groove"
        return f"revolved {words}" if words in ("flat", "round") else "general revolution"

    def shape(self, entity: Entity, kind: str, placement: Matrix, base: Shape | None, place: Matrix) -> Shape:
        """Return the shape of a turned feature.

        Args:
            entity: The feature.
            kind: Its `kind`.
            placement: Of the feature.
            base: Shape that a thread is cut into, else None.
            place: Its placement.

        Raises:
            Skip: where nothing can be turned by it.
        """
        components = self.shapes.components(entity.id)
        if kind == "outer diameter":
            return self._outer_diameter(entity, components)
        if kind == "thread":
            return self._thread(entity, components, placement, base, place)
        if kind == "groove" or kind.startswith(("revolved", "general")):
            return self._revolved(entity, kind, components)
        text = f"no toolpath can be made for a {kind}; give explicit toolpaths"
        raise entity.fault("stepnc-unsupported", text)

    def _outer_diameter(self, entity: Entity, components: list[Component]) -> Shape:
        size = self.shapes.measures(entity.id)
        if not (size.get("diameter", 0.0) > 0 and size.get("length", 0.0) > 0):
            raise entity.fault("stepnc-missing", "an outer diameter needs its diameter and length, above 0")
        first = last = size["diameter"]
        taper = component_of(components, "taper", ("TAPER",))
        if taper is not None:
            ends = self.shapes.measures(taper.id)
            if not {"final diameter", "taper angle"} & set(ends):
                raise taper.fault("stepnc-missing", "the taper has no final diameter and no taper angle")
            narrowed = first - 2 * size["length"] * math.tan(ends.get("taper angle", 0.0))
            last = ends.get("final diameter", narrowed)
        return Shape(contour=turned_shapes.diameter(entity, (first, last), size["length"]))

    def _revolved(self, entity: Entity, kind: str, components: list[Component]) -> Shape:
        profile = profile_of(components, OPEN)
        if profile is None:
            raise entity.fault("stepnc-missing", "the turned feature has no profile")
        radius = self.shapes.measures(entity.id).get("radius", 0.0)
        material = self.shapes.direction(entity.id, "removal direction")
        if kind == "groove" and profile.keyword in _GROOVES:
            place = self.shapes.frame(profile.id, "orientation")
            made = turned_shapes.groove(profile, self.profiles.across(profile), place, radius)
            return replace(made, material=material)
        if profile.keyword == "PARTIAL_CIRCULAR_PROFILE":
            size = self.shapes.measures(profile.id)
            if not {"radius", "sweep angle"} <= set(size):
                raise profile.fault("stepnc-missing", "the arc has no radius or no sweep angle")
            pieces: list[Piece] = [profile_shapes.arc_path(profile, size["radius"], size["sweep angle"])]
            pieces = self.profiles.placed(profile, pieces)
        else:
            pieces = self.profiles.open(profile)
        return Shape(contour=turned_shapes.in_plane(profile, pieces, radius), material=material)

    def base_of(self, entity: Entity) -> int | None:
        """Return the feature that a thread is cut into, None where the file names none."""
        base = find(self.shapes.components(entity.id), "applied shape")
        return None if base is None else base.id

    def _thread(
        self,
        entity: Entity,
        components: list[Component],
        placement: Matrix,
        base: Shape | None,
        place: Matrix,
    ) -> Shape:
        """Return the hole or the profile of the diameter that a thread is cut into, in the thread's frame."""
        if base is None:
            raise entity.fault(
                "stepnc-missing", "no relationship 'applied shape' leads to what the thread is on"
            )
        size = self.shapes.measures(entity.id)
        area = component_of(components, "applied area", ("APPLIED_AREA",))
        length = {} if area is None else self.shapes.measures(area.id)
        threaded = replace(base, thread=size.get("major diameter"), pitch=self._pitch(entity))
        if base.contour is None:
            return threaded
        into = elementary.product(np.asarray(np.linalg.inv(placement), np.float64), place)
        return replace(
            threaded,
            contour=[p.moved(into) for p in base.contour],
            diameter=size.get("minor diameter"),
            width=length.get("effective length", length.get("length")),
        )

    def _pitch(self, entity: Entity) -> float | None:
        """Return the pitch of a thread, mm, negative if left-handed; None where the number of threads is not given."""
        items = {item.name: item for item in self.shapes.items(entity.id)}
        count = self.shapes.measures(entity.id).get("number of threads")
        if count is None:
            return None
        if not count > 0:
            raise entity.fault("stepnc-geometry", f"{count:g} threads")
        pitch = self._unit_of(items.get("major diameter")) / count
        if pitch < FINEST:
            text = f"{count:g} threads a mm make a pitch of {pitch:.3g} mm; they are taken as threads an inch"
            entity.warn("stepnc-unit", text)
            pitch = INCH / count
        return -pitch if "left" in self.shapes.words(entity.id) else pitch

    def _unit_of(self, item: Item | None) -> float:
        """Return the unit of a measure, mm; 1 without one."""
        measure = None if item is None else self.shapes.units.measure(item.entity)
        return 1.0 if measure is None else measure.unit.factor
