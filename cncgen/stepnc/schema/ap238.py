"""The entities of the AP238 AIM (ISO 10303-238) that an executor meets, in Part 21 order.

A line an entity, as in `cncgen.stepnc.schema.iso14649`.
"""

HEADS = {
    "METHOD": "name:s description:s consequence:s purpose:s",
    "RELATION": "name:s description:s relating_method:r related_method:r",
}

ENTITIES = """
ACTION_PROPERTY name:s description:s definition:r
ACTION_PROPERTY_REPRESENTATION name:s description:s property:r representation:r
ACTION_RESOURCE_RELATIONSHIP name:s description:s relating_resource:r related_resource:r
ACTION_RESOURCE_TYPE name:s
APPLICATION_CONTEXT application:s
APPLIED_AREA name:s description:s of_shape:r product_definitional:e
AXIS2_PLACEMENT_3D name:s location:r=CARTESIAN_POINT axis:r=DIRECTION ref_direction:r=DIRECTION
BACK_BORING_OPERATION &METHOD
BORING_OPERATION &METHOD
BOSS name:s description:s
BOTTOM_AND_SIDE_MILLING_OPERATION &METHOD
BOUNDED_CURVE name:s
B_SPLINE_CURVE name:s degree:n control_points_list:l curve_form:e closed_curve:e self_intersect:e
B_SPLINE_CURVE_WITH_KNOTS name:s degree:n control_points_list:l curve_form:e closed_curve:e self_intersect:e knot_multiplicities:l knots:l knot_spec:e
CARTESIAN_POINT name:s coordinates:l
CHARACTERIZED_OBJECT name:s description:s
CIRCLE name:s position:r radius:n
CIRCULAR_CLOSED_PROFILE name:s description:s of_shape:r product_definitional:e
CIRCULAR_PATTERN name:s description:s
CLOSED_PATH_PROFILE name:s description:s of_shape:r product_definitional:e
COMPOSITE_CURVE name:s segments:l self_intersect:e
COMPOSITE_CURVE_SEGMENT transition:e same_sense:e parent_curve:r
COMPOSITE_HOLE name:s description:s
COMPOSITE_SHAPE_ASPECT name:s description:s of_shape:r product_definitional:e
COMPOUND_FEATURE name:s description:s
COMPOUND_REPRESENTATION_ITEM name:s item_element:*
CONTEXT_DEPENDENT_SHAPE_REPRESENTATION representation_relation:r represented_product_relation:r
CONTEXT_DEPENDENT_UNIT dimensions:* name:s
CONVERSION_BASED_UNIT dimensions:* name:s conversion_factor:r
DERIVED_UNIT elements:l
DERIVED_UNIT_ELEMENT unit:r exponent:n
DESCRIPTIVE_REPRESENTATION_ITEM name:s description:s
DIMENSIONAL_EXPONENTS length_exponent:n mass_exponent:n time_exponent:n electric_current_exponent:n thermodynamic_temperature_exponent:n amount_of_substance_exponent:n luminous_intensity_exponent:n
DIRECTION name:s direction_ratios:l
DIRECTION_SHAPE_REPRESENTATION name:s items:l context_of_items:r
DRILLING_OPERATION &METHOD
DRILLING_TYPE_STRATEGY &METHOD
ELLIPSE name:s position:r semi_axis_1:n semi_axis_2:n
FEATURE_COMPONENT_RELATIONSHIP name:s description:s relating_shape_aspect:r related_shape_aspect:r
FEATURE_DEFINITION name:s description:s
FEATURE_PATTERN name:s description:s
FLAT_FACE name:s description:s
FREEFORM_MILLING_OPERATION &METHOD
FREEFORM_MILLING_STRATEGY &METHOD
GEOMETRIC_REPRESENTATION_CONTEXT context_identifier:s context_type:s coordinate_space_dimension:n
GEOMETRIC_REPRESENTATION_ITEM name:s
GLOBAL_UNIT_ASSIGNED_CONTEXT context_identifier:s context_type:s units:l
HOLE_BOTTOM name:s description:s of_shape:r product_definitional:e
INSTANCED_FEATURE name:s description:s name:s description:s of_shape:r product_definitional:e
ITEM_DEFINED_TRANSFORMATION name:s description:s transform_item_1:r transform_item_2:r
LENGTH_MEASURE_WITH_UNIT value_component:* unit_component:r
LIMITS_AND_FITS form_variance:s zone_variance:s grade:s source:s
LINE name:s pnt:r=CARTESIAN_POINT dir:r=VECTOR
LINEAR_PATH t_end:n transition:e placement_end:r
LINEAR_PROFILE name:s description:s of_shape:r product_definitional:e
MACHINING_ADAPTIVE_CONTROL_RELATIONSHIP &RELATION
MACHINING_APPROACH_RETRACT_STRATEGY &METHOD
MACHINING_CUTTING_COMPONENT name:s description:s usage:l kind:r name:s description:s
MACHINING_CUTTING_CORNER_REPRESENTATION name:s items:l context_of_items:r
MACHINING_DWELL_TIME_REPRESENTATION name:s items:l context_of_items:r
MACHINING_EXECUTION_RESOURCE name:s description:s usage:l kind:r
MACHINING_FEATURE_PROCESS &METHOD
MACHINING_FEATURE_RELATIONSHIP &RELATION
MACHINING_FEATURE_SEQUENCE_RELATIONSHIP &RELATION sequence_position:n
MACHINING_FEED_SPEED_REPRESENTATION name:s items:l context_of_items:r
MACHINING_FINAL_FEATURE_RELATIONSHIP &RELATION
MACHINING_FIXTURE_USAGE &METHOD
MACHINING_FUNCTIONS &METHOD
MACHINING_FUNCTIONS_RELATIONSHIP &RELATION
MACHINING_MACHINE_USAGE &METHOD
MACHINING_NC_FUNCTION &METHOD
MACHINING_OFFSET_VECTOR_REPRESENTATION name:s items:l context_of_items:r
MACHINING_OPERATION &METHOD
MACHINING_OPERATION_RELATIONSHIP &RELATION
MACHINING_OPERATOR_INSTRUCTION &METHOD documents:l
MACHINING_OPERATOR_INSTRUCTION_RELATIONSHIP &RELATION sequence_position:n
MACHINING_PROCESS_BODY_RELATIONSHIP &RELATION
MACHINING_PROCESS_BRANCH_RELATIONSHIP &RELATION
MACHINING_PROCESS_CONCURRENT_RELATIONSHIP &RELATION
MACHINING_PROCESS_EXECUTABLE &METHOD
MACHINING_PROCESS_MODEL &METHOD
MACHINING_PROCESS_MODEL_RELATIONSHIP &RELATION sequence_position:n
MACHINING_PROCESS_PROPERTY name:s description:s definition:r
MACHINING_PROCESS_SEQUENCE_RELATIONSHIP &RELATION sequence_position:n
MACHINING_PROJECT id:s name:s description:s frame_of_reference:l
MACHINING_PROJECT_WORKPIECE_RELATIONSHIP id:s name:s description:s relating_product_definition:r related_product_definition:r
MACHINING_RAPID_MOVEMENT &METHOD
MACHINING_SETUP id:s name:s description:s frame_of_reference:l
MACHINING_SETUP_WORKPIECE_RELATIONSHIP id:s name:s description:s relating_product_definition:r related_product_definition:r
MACHINING_SPINDLE_SPEED_REPRESENTATION name:s items:l context_of_items:r
MACHINING_STRATEGY &METHOD
MACHINING_STRATEGY_RELATIONSHIP &RELATION
MACHINING_TECHNOLOGY &METHOD
MACHINING_TECHNOLOGY_RELATIONSHIP &RELATION
MACHINING_TOOL name:s description:s usage:l kind:r
MACHINING_TOOLPATH &METHOD
MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP &RELATION sequence_position:n
MACHINING_TOOLPATH_SPEED_PROFILE_REPRESENTATION name:s items:l context_of_items:r
MACHINING_TOOL_BODY_REPRESENTATION name:s items:l context_of_items:r
MACHINING_TOOL_DIRECTION_REPRESENTATION name:s items:l context_of_items:r
MACHINING_TOOL_USAGE &METHOD
MACHINING_TOUCH_PROBING &METHOD
MACHINING_TWIN_RELATIONSHIP &RELATION
MACHINING_USAGE_RELATIONSHIP &RELATION
MACHINING_WORKINGSTEP &METHOD
MACHINING_WORKPLAN &METHOD
MEASURE_REPRESENTATION_ITEM name:s value_component:* unit_component:r
MEASURE_WITH_UNIT value_component:* unit_component:r
MILLING_TYPE_OPERATION &METHOD
MILLING_TYPE_STRATEGY &METHOD
MAKE_FROM_USAGE_OPTION id:s name:s description:s relating_product_definition:r related_product_definition:r ranking:n ranking_rationale:s quantity:r
NAMED_UNIT dimensions:*
NGON_CLOSED_PROFILE name:s description:s of_shape:r product_definitional:e
OPEN_PATH_PROFILE name:s description:s of_shape:r product_definitional:e
OUTER_ROUND name:s description:s
OUTSIDE_PROFILE name:s description:s
PARTIAL_CIRCULAR_PROFILE name:s description:s of_shape:r product_definitional:e
PATH_FEATURE_COMPONENT name:s description:s of_shape:r product_definitional:e
PATH_SHAPE_REPRESENTATION name:s items:l context_of_items:r
PATTERN_OFFSET_MEMBERSHIP name:s description:s relating_shape_aspect:r related_shape_aspect:r
PATTERN_OMIT_MEMBERSHIP name:s description:s relating_shape_aspect:r related_shape_aspect:r
PLANAR_SHAPE_REPRESENTATION name:s items:l context_of_items:r
PLANE name:s position:r=AXIS2_PLACEMENT_3D
PLANE_ANGLE_MEASURE_WITH_UNIT value_component:* unit_component:r
PLANE_MILLING_OPERATION &METHOD
POCKET name:s description:s
POCKET_BOTTOM name:s description:s of_shape:r product_definitional:e
POLYLINE name:s points:l
PROCESS_OPERATION &METHOD
PROCESS_PRODUCT_ASSOCIATION name:s description:s defined_product:r process:r
PROCESS_PROPERTY_ASSOCIATION name:s description:s process:r property_or_shape:r
PRODUCT id:s name:s description:s frame_of_reference:l
PRODUCT_CONTEXT name:s frame_of_reference:r discipline_type:s
PRODUCT_DEFINITION id:s description:s formation:r frame_of_reference:r
PRODUCT_DEFINITION_CONTEXT name:s frame_of_reference:r life_cycle_stage:s
PRODUCT_DEFINITION_FORMATION id:s description:s of_product:r
PRODUCT_DEFINITION_PROCESS name:s description:s chosen_method:r identification:s
PRODUCT_DEFINITION_RELATIONSHIP id:s name:s description:s relating_product_definition:r related_product_definition:r
PRODUCT_DEFINITION_SHAPE name:s description:s definition:r
PROPERTY_DEFINITION name:s description:s definition:r
PROPERTY_DEFINITION_REPRESENTATION definition:r used_representation:r
PROPERTY_PROCESS name:s description:s chosen_method:r identification:s
QUASI_UNIFORM_CURVE name:s degree:n control_points_list:l curve_form:e closed_curve:e self_intersect:e
RATIONAL_B_SPLINE_CURVE name:s degree:n control_points_list:l curve_form:e closed_curve:e self_intersect:e weights_data:l
RECTANGULAR_CLOSED_PROFILE name:s description:s of_shape:r product_definitional:e
RECTANGULAR_PATTERN name:s description:s
REPRESENTATION name:s items:l context_of_items:r
REPRESENTATION_CONTEXT context_identifier:s context_type:s
REPRESENTATION_ITEM name:s
RESOURCE_PROPERTY name:s description:s resource:r
RESOURCE_PROPERTY_REPRESENTATION name:s description:s property:r representation:r
REVOLVED_PROFILE name:s description:s
ROUNDED_U_PROFILE name:s description:s of_shape:r product_definitional:e
ROUND_HOLE name:s description:s
SHAPE_ASPECT name:s description:s of_shape:r product_definitional:e
SHAPE_DEFINING_RELATIONSHIP name:s description:s relating_shape_aspect:r related_shape_aspect:r
SHAPE_DEFINITION_REPRESENTATION definition:r used_representation:r
SHAPE_REPRESENTATION name:s items:l context_of_items:r
SHAPE_REPRESENTATION_WITH_PARAMETERS name:s items:l context_of_items:r
SIDE_MILLING_OPERATION &METHOD
SI_UNIT dimensions:* prefix:e name:e
SLOT name:s description:s
SLOT_END name:s description:s of_shape:r product_definitional:e
SQUARE_U_PROFILE name:s description:s of_shape:r product_definitional:e
STEP name:s description:s
TAPER name:s description:s of_shape:r product_definitional:e
TAPPING_OPERATION &METHOD
TEE_PROFILE name:s description:s of_shape:r product_definitional:e
THREAD name:s description:s
TRIMMED_CURVE name:s basis_curve:r trim_1:l trim_2:l sense_agreement:e master_representation:e
CONTOURING_TURNING_OPERATION &METHOD
FACING_TURNING_OPERATION &METHOD
GROOVING_TURNING_OPERATION &METHOD
KNURLING_TURNING_OPERATION &METHOD
THREADING_TURNING_OPERATION &METHOD
TURNING_TYPE_OPERATION &METHOD
TURNING_TYPE_STRATEGY &METHOD
VECTOR name:s orientation:r=DIRECTION magnitude:n
VEE_PROFILE name:s description:s of_shape:r product_definitional:e
VIA_ARC_POINT name:s coordinates:l
VIA_HELIX_POINT name:s coordinates:l
"""
