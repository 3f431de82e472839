"""The entities of ISO 14649-12 (turning) and -121 (its tools), in Part 21 order, as far as an executor needs them.

A line an entity, as in `cncgen.stepnc.schema.iso14649`; ``others:+`` stands for attributes at the end that cncgen does not use.
"""

HEADS = {
    "TUR": "&OP8 approach:r retract:r its_machining_strategy:r",
    "REVOLVED": "&F4 material_side:r=DIRECTION radius:*",
    "STRATEGY": "overcut_length:n allow_multiple_passes:e cutting_depth:l variable_feedrate:n",
    "WAYS": "feed_direction:r=DIRECTION back_path_direction:r=DIRECTION lift_direction:r=DIRECTION stepover_direction:r=DIRECTION lift_height:n lift_feed:* stepover_feed:*",
}
#: Further attributes of operations by the first word of their names.
_OWN = {"GROOVING": "dwell:* allowance:n", "CUTTING": "dwell:* allowance:n", "KNURLING": ""}

#: Operations; `cncgen.stepnc.features.turned` says which need no toolpaths.
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

_KNURLS = ("STRAIGHT_KNURL", "DIAGONAL_KNURL", "DIAMOND_KNURL", "TOOL_KNURL", "CATALOGUE_KNURL")

ENTITIES = (
    """
BIDIRECTIONAL_TURNING &STRATEGY feed_direction:r=DIRECTION others:+
CONST_CUTTING_SPEED speed:n max_speed:n
CONST_SPINDLE_SPEED rot_speed:n
CONTOUR_TURNING &STRATEGY &WAYS
CORNER_TRANSITION corner_identity:n transition:r
CUTTING_EDGE_PROPERTIES expected_tool_life:n its_technology:r cutting_edge_length:n tool_cutting_edge_angle:n tool_cutting_edge_angle_type:* tool_included_angle:n corner_transitions:l others:+
CUT_IN &F4 others:+
EXPLICIT_TURNING_STRATEGY &STRATEGY
GENERAL_REVOLUTION &REVOLVED outer_edge_profile:r
GENERAL_TURNING_TOOL dimension:* hand_of_tool:* others:+
GROOVE &REVOLVED sweep:r
GROOVING_STRATEGY &STRATEGY grooving_direction:r=DIRECTION travel_distance:n
GROOVING_TOOL dimension:* hand_of_tool:* others:+
MULTISTEP_GROOVING_STRATEGY &STRATEGY grooving_direction:r=DIRECTION travel_distance:n retract_distance:n others:+
OUTER_DIAMETER &F4 diameter_at_placement:* feature_length:* reduced_size:r
OUTER_DIAMETER_TO_SHOULDER &F4 diameter_at_placement:* v_shape_boundary:r
OUTER_ROUND &F4 others:+
REVOLVED_FLAT &REVOLVED flat_edge_shape:r
REVOLVED_ROUND &REVOLVED rounded_edge_shape:r
ROUNDED_CORNER corner_radius:*
THREAD_STRATEGY &STRATEGY cut_in_amount_function:e threading_direction:e path_return_angle:n lift_height:n others:+
TURNING_CUTTING_TOOL its_id:s others:+
TURNING_MACHINE_FUNCTIONS coolant:e coolant_type:e others:+
TURNING_MACHINE_TOOL its_id:s its_tool_body:* others:+
TURNING_TECHNOLOGY feedrate:n feedrate_reference:e spindle_speed:r feed_per_revolution:n sync_spindle_and_z_feed:e others:+
TURNING_THREADING_TOOL dimension:* hand_of_tool:* others:+
TURNING_TOOL_DIMENSION cutting_edge_length:n side_rake_angle:n side_relief_angle:n side_clearance_angle:n end_cutting_edge_angle:n side_cutting_edge_angle:n back_rake_angle:n end_relief_angle:n end_clearance_angle:n nose_radius:n circle_diameter:n
TURNING_WORKINGSTEP its_id:s its_secplane:r its_feature:* its_operation:r others:+
UNIDIRECTIONAL_TURNING &STRATEGY &WAYS
USER_DEFINED_TURNING_TOOL dimension:* hand_of_tool:* others:+
"""
    + "\n".join(f"{name} &TUR {_OWN.get(name.split('_')[0], 'allowance:n')} others:+" for name in OPERATIONS)
    + "\n"
    + "\n".join(f"{name} &F4 others:+" for name in _KNURLS)
)
