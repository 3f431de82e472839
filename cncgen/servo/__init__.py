"""Servo axes: plants, controllers, closed-loop simulation, identification and design.

    plants, controllers     a plant and a controller as linear systems, one controller a file with its source
    models                  both from the servo table of a machine file
    loop                    plant and controller joined to the closed loop of an axis (`AxisLoop`), as tables for the kernel
    scheme, named_schemes   the loops of all axes, with what shapes their setpoints or couples them (`Scheme`)
    bank, simulate          runs a scheme along setpoints: `Setpoints` → `Response`
    contour, summary        contour error and other figures of a response; `wanted_motion` judges it by the program
    norm_optimal, learning  commands that make the axes follow better, within their limits; `compensation` judges them
    mirror, inversion       such commands as the papers have them
    shaping                 commands that excite no vibration
    uncertainty             machines whose parameters are not quite the model's
    identification          from a logged motion to a servo model
    tuning                  gains for a bandwidth, or for the least contour error, with the margins of their loops

Names are imported from their modules; `simulate` and `Response` are the two that most callers need. Pages:
docs/servo-models.md, docs/controllers.md, docs/identification.md, docs/contour-error.md.
"""

from cncgen.servo.record import Response
from cncgen.servo.simulate import simulate

__all__ = ["Response", "simulate"]
