"""The entities of ISO 14649-12 (turning) and -121 (its tools), in Part 21 order, as far as an executor needs them.

A line an entity, as in `cncgen.stepnc.schema.iso14649`; ``others:+`` stands for attributes at the end that nothing here asks for.
"""

HEADS = {"TUR": "&OP8 approach:r retract:r its_machining_strategy:r"}

#: Operations; without toolpaths of the file they cannot be made.
OPERATIONS = (
    "FACING_ROUGH",
    "FACING_FINISH",
    "CONTOURING_ROUGH",
    "CONTOURING_FINISH",
    "GROOVING_ROUGH",
    "GROOVING_FINISH",
    "CUTTING_IN",
    "THREADING_ROUGH",
    "THREADING_FINISH",
    "KNURLING",
)
_FEATURES = (
    "REVOLVED_FLAT",
    "REVOLVED_ROUND",
    "OUTER_ROUND",
    "OUTER_DIAMETER",
    "OUTER_DIAMETER_TO_SHOULDER",
    "GENERAL_REVOLUTION",
    "GROOVE",
    "CUT_IN",
    "EDGE_ROUND",
    "STRAIGHT_KNURL",
    "DIAGONAL_KNURL",
    "DIAMOND_KNURL",
    "TOOL_KNURL",
    "CATALOGUE_KNURL",
)

ENTITIES = (
    """
CONST_CUTTING_SPEED speed:n max_speed:n
CONST_SPINDLE_SPEED rot_speed:n
TURNING_CUTTING_TOOL its_id:s others:+
TURNING_MACHINE_FUNCTIONS coolant:e others:+
TURNING_MACHINE_TOOL its_id:s others:+
TURNING_TECHNOLOGY feedrate:n feedrate_reference:e spindle_speed:r feed_per_revolution:n sync_spindle_and_z_feed:e others:+
TURNING_WORKINGSTEP its_id:s its_secplane:r its_feature:* its_operation:r others:+
"""
    + "\n".join(f"{name} &TUR others:+" for name in OPERATIONS)
    + "\n"
    + "\n".join(f"{name} &F4 others:+" for name in _FEATURES)
)
