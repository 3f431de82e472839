"""The entities of ISO 14649-10, -11 and -111 in Part 21 order, inherited attributes included.

A line an entity: its name, then ``attribute:kind`` (the kinds are those of `cncgen.stepnc.schema.tables`); ``&HEAD``
stands for a head that many entities share. The 2001 drafts' names UNIDIRECTIONAL, BIDIRECTIONAL, EXPLICIT and
RETURN_HOME are here beside those of the standard.
"""

HEADS = {
    "OP8": "its_toolpath:r=TOOLPATH_LIST its_tool_direction:r its_id:s retract_plane:n start_point:r=CARTESIAN_POINT its_tool:r its_technology:r its_machine_functions:r",
    "MIL": "&OP8 overcut_length:n approach:r retract:r its_machining_strategy:r",
    "DRI": "&OP8 overcut_length:n cutting_depth:n previous_diameter:n dwell_time_bottom:n feed_on_retract:n its_machining_strategy:r",
    "TP": "its_priority:e its_type:e its_speed:* its_technology:r its_machine_functions:r",
    "F4": "its_id:s its_workpiece:r=WORKPIECE its_operations:l feature_placement:r=AXIS2_PLACEMENT_3D",
    "F5": "&F4 depth:r",
    "BODY": "dimension:r=MILLING_TOOL_DIMENSION number_of_teeth:n hand_of_cut:e coolant_through_tool:e pilot_length:n",
}

#: Attributes at the end that an entity of the 2001 draft does not have.
LATER_ATTRIBUTES = {"CUTTING_COMPONENT": 1}

ENTITIES = """
ADVANCED_BREP_SHAPE_REPRESENTATION name:s items:l context_of_items:r
ADVANCED_FACE name:s bounds:l face_geometry:r same_sense:e
AIR_STRATEGY tool_orientation:r=DIRECTION
ALONG_PATH tool_orientation:r=DIRECTION path:r=TOOLPATH_LIST
AND_EXPRESSION operands:l
ANGLE_TAPER angle:n
APPROACH_LIFT_PATH &TP fix_point:r=CARTESIAN_POINT fix_point_dir:r=DIRECTION
APPROACH_RETRACT_STRATEGY tool_orientation:r=DIRECTION
APPROVAL status:r level:s
APPROVAL_STATUS name:s
AP_LIFT_PATH_ANGLE &TP fix_point:r=CARTESIAN_POINT fix_point_dir:r=DIRECTION angle:n benddist:n
AP_LIFT_PATH_TANGENT &TP fix_point:r=CARTESIAN_POINT fix_point_dir:r=DIRECTION radius:n
AP_RETRACT_ANGLE tool_orientation:r=DIRECTION angle:n travel_length:n
AP_RETRACT_TANGENT tool_orientation:r=DIRECTION radius:n
ASSIGNMENT its_id:s its_lvalue:r its_rvalue:*
AXIS1_PLACEMENT name:s location:r=CARTESIAN_POINT axis:r=DIRECTION
AXIS2_PLACEMENT_3D name:s location:r=CARTESIAN_POINT axis:r=DIRECTION ref_direction:r=DIRECTION
AXIS_TRAJECTORY &TP its_direction:e axis_list:l commands:l
BACKSIDE_COUNTERBORE &BODY
BACKSIDE_COUNTERSINK &BODY countersink_radius:n
BACK_BORING &DRI
BALL_ENDMILL &BODY
BEZIER_CURVE name:s degree:n control_points_list:l curve_form:e closed_curve:e self_intersect:e
BEZIER_SURFACE name:s u_degree:n v_degree:n control_points_list:l surface_form:e u_closed:e v_closed:e self_intersect:e
BIDIRECTIONAL overlap:n allow_multiple_passes:e feed_direction:r=DIRECTION stepover_direction:e its_stroke_connection_strategy:e
BIDIRECTIONAL_CONTOUR overlap:n allow_multiple_passes:e feed_direction:r=DIRECTION stepover_direction:e rotation_direction:e spiral_cutmode:e
BIDIRECTIONAL_MILLING overlap:n allow_multiple_passes:e feed_direction:r=DIRECTION stepover_direction:e its_stroke_connection_strategy:e
BINARY_BOOLEAN_EXPRESSION operand1:r operand2:r
BLIND_BOTTOM_CONDITION
BLOCK name:s position:r=AXIS2_PLACEMENT_3D x:n y:n z:n
BORING &DRI spindle_stop_at_bottom:e depth_of_testcut:n waiting_position:r=CARTESIAN_POINT
BORING_OPERATION &DRI spindle_stop_at_bottom:e depth_of_testcut:n waiting_position:r=CARTESIAN_POINT
BORING_TOOL &BODY
BOSS &F5 its_boundary:r slope:n
BOTTOM_AND_SIDE_FINISH_MILLING &MIL axial_cutting_depth:n radial_cutting_depth:n allowance_side:n allowance_bottom:n
BOTTOM_AND_SIDE_MILLING &MIL axial_cutting_depth:n radial_cutting_depth:n allowance_side:n allowance_bottom:n
BOTTOM_AND_SIDE_ROUGH_MILLING &MIL axial_cutting_depth:n radial_cutting_depth:n allowance_side:n allowance_bottom:n
BOUNDED_CURVE name:s
BOUNDED_PCURVE name:s basis_surface:r reference_to_curve:r
BOUNDED_SURFACE name:s
BULLNOSE_ENDMILL &BODY
B_SPLINE_CURVE name:s degree:n control_points_list:l curve_form:e closed_curve:e self_intersect:e
B_SPLINE_CURVE_WITH_KNOTS name:s degree:n control_points_list:l curve_form:e closed_curve:e self_intersect:e knot_multiplicities:l knots:l knot_spec:e
B_SPLINE_SURFACE name:s u_degree:n v_degree:n control_points_list:l surface_form:e u_closed:e v_closed:e self_intersect:e
B_SPLINE_SURFACE_WITH_KNOTS name:s u_degree:n v_degree:n control_points_list:l surface_form:e u_closed:e v_closed:e self_intersect:e u_multiplicities:l v_multiplicities:l u_knots:l v_knots:l knot_spec:e
CALENDAR_DATE year_component:n day_component:n month_component:n
CARTESIAN_POINT name:s coordinates:l
CATALOGUE_THREAD &F5 partial_profile:* applied_shape:l inner_or_outer_thread:e qualifier:r fit_class:r form:r major_diameter:n number_of_threads:r=NUMERIC_PARAMETER thread_hand:r documentation:r
CENTER_DRILL &BODY
CENTER_DRILLING &DRI
CENTER_MILLING overlap:n allow_multiple_passes:e
CHAMFER its_id:s its_workpiece:r=WORKPIECE its_operations:l first_feature:r second_feature:r angle_to_plane:n first_offset_amount:r=TOLERANCED_LENGTH_MEASURE
CHANNEL its_id:s
CIRCLE name:s position:r=AXIS2_PLACEMENT_3D radius:n
CIRCULAR_CLOSED_PROFILE placement:r=AXIS2_PLACEMENT_3D diameter:r=TOLERANCED_LENGTH_MEASURE
CIRCULAR_CLOSED_SHAPE_PROFILE &F5 profile_swept_shape:r floor_condition:* removal_direction:r=DIRECTION closed_boundary:r
CIRCULAR_OFFSET angular_offset:n index:n
CIRCULAR_OMIT index:n
CIRCULAR_PATH placement:r=AXIS2_PLACEMENT_3D radius:r=TOLERANCED_LENGTH_MEASURE
CIRCULAR_PATTERN &F4 replicate_base_feature:r angle_increment:n number_of_feature:n relocated_base_feature:l missing_base_feature:l base_feature_diameter:r=TOLERANCED_LENGTH_MEASURE base_feature_rotation:n
CLOSED_POCKET &F5 its_boss:l slope:n bottom_condition:r planar_radius:r=TOLERANCED_LENGTH_MEASURE orthogonal_radius:r=TOLERANCED_LENGTH_MEASURE feature_boundary:r
CLOSED_PROFILE placement:r=AXIS2_PLACEMENT_3D
CLOSED_SHELL name:s cfs_faces:l
COMBINED_DRILL_AND_REAMER &BODY drill_length:n
COMBINED_DRILL_AND_TAP &BODY drill_length:n
COMPARISON_EQUAL operand1:r operand2:*
COMPARISON_EXPRESSION operand1:r operand2:*
COMPARISON_GREATER operand1:r operand2:*
COMPARISON_GREATER_EQUAL operand1:r operand2:*
COMPARISON_LESS operand1:r operand2:*
COMPARISON_LESS_EQUAL operand1:r operand2:*
COMPARISON_NOT_EQUAL operand1:r operand2:*
COMPLETE_CIRCULAR_PATH placement:r=AXIS2_PLACEMENT_3D radius:r=TOLERANCED_LENGTH_MEASURE
COMPOSITE_CURVE name:s segments:l self_intersect:e
COMPOSITE_CURVE_SEGMENT transition:e same_sense:e parent_curve:r
COMPOUND_FEATURE &F4 elements:l
CONIC name:s position:r=AXIS2_PLACEMENT_3D
CONICAL_HOLE_BOTTOM tip_angle:n tip_radius:r=TOLERANCED_LENGTH_MEASURE
CONNECTED_FACE_SET name:s cfs_faces:l
CONNECTOR &TP
CONNECT_DIRECT &TP
CONNECT_SECPLANE &TP up_dir:r=DIRECTION down_dir:r=DIRECTION
CONTOUR_BIDIRECTIONAL overlap:n allow_multiple_passes:e feed_direction:r=DIRECTION stepover_direction:e rotation_direction:e spiral_cutmode:e
CONTOUR_PARALLEL overlap:n allow_multiple_passes:e rotation_direction:e cutmode:e
CONTOUR_SPIRAL overlap:n allow_multiple_passes:e rotation_direction:e cutmode:e
COORDINATED_UNIVERSAL_TIME_OFFSET hour_offset:n minute_offset:n sense:e
COUNTERBORE &BODY
COUNTERBORE_HOLE &F4 elements:l
COUNTERSINK &BODY countersink_radius:n
COUNTERSUNK_HOLE &F4 elements:l
COUNTER_SINKING &DRI
CURVE name:s
CURVE_WITH_NORMAL_VECTOR basiccurve:r surface_normal:r
CUTTER_CONTACT_TRAJECTORY &TP its_direction:e basiccurve:r its_toolaxis:r its_contact_type:e
CUTTER_LOCATION_TRAJECTORY &TP its_direction:e basiccurve:r its_toolaxis:r surface_normal:r
CUTTING_COMPONENT tool_offset_length:n its_material:r=MATERIAL technological_data:r expected_tool_life:n its_technology:r=MILLING_TECHNOLOGY
CUTTING_EDGE_TECHNOLOGICAL_DATA cutting_angle:n free_angle:n aux_angle:n
CUTTING_TOOL its_id:s its_tool_body:r its_cutting_edge:l overall_assembly_length:n
DATE year_component:n
DATE_AND_TIME date_component:r time_component:r
DEFINED_THREAD &F5 partial_profile:* applied_shape:l inner_or_outer_thread:e qualifier:r fit_class:r form:r major_diameter:n number_of_threads:r=NUMERIC_PARAMETER thread_hand:r pitch_diameter:n minor_diameter:n crest:n
DEFINITIONAL_REPRESENTATION name:s items:l context_of_items:r
DESCRIPTIVE_PARAMETER parameter_name:s descriptive_string:s
DIAMETER_TAPER final_diameter:r=TOLERANCED_LENGTH_MEASURE
DIRECTION name:s direction_ratios:l
DISPLAY_MESSAGE its_id:s its_text:s
DOVETAIL_MILL &BODY included_angle:n
DRILL &BODY
DRILLING &DRI
DRILLING_OPERATION &DRI
DRILLING_TYPE_OPERATION &DRI
DRILLING_TYPE_STRATEGY reduced_cut_at_start:n reduced_feed_at_start:n depth_of_start:n reduced_cut_at_end:n reduced_feed_at_end:n depth_of_end:n
EDGE name:s edge_start:r edge_end:r
EDGE_CURVE name:s edge_start:r edge_end:r edge_geometry:r same_sense:e
EDGE_LOOP name:s edge_list:l
EDGE_ROUND its_id:s its_workpiece:r=WORKPIECE its_operations:l first_feature:r second_feature:r radius:r=TOLERANCED_LENGTH_MEASURE first_offset_amount:r=TOLERANCED_LENGTH_MEASURE second_offset_amount:r=TOLERANCED_LENGTH_MEASURE
ELEMENTARY_SURFACE name:s position:r=AXIS2_PLACEMENT_3D
ELLIPSE name:s position:r=AXIS2_PLACEMENT_3D semi_axis_1:n semi_axis_2:n
ENDMILL &BODY
EXCHANGE_PALLET its_id:s
EXECUTABLE its_id:s
EXPLICIT overlap:n allow_multiple_passes:e
EXPLICIT_STRATEGY overlap:n allow_multiple_passes:e
FACE name:s bounds:l
FACEMILL &BODY
FACE_BOUND name:s bound:r orientation:e
FACE_OUTER_BOUND name:s bound:r orientation:e
FACE_SURFACE name:s bounds:l face_geometry:r same_sense:e
FEEDSTOP &TP dwell:n
FIVE_AXES_CONST_TILT_YAW tilt_angle:n yaw_angle:n
FIVE_AXES_VAR_TILT_YAW
FLAT_HOLE_BOTTOM
FLAT_SLOT_END_TYPE corner_radius1:r=TOLERANCED_LENGTH_MEASURE corner_radius2:r=TOLERANCED_LENGTH_MEASURE
FLAT_WITH_RADIUS_HOLE_BOTTOM corner_radius:r=TOLERANCED_LENGTH_MEASURE
FREEFORM_OPERATION &MIL
FREEFORM_STRATEGY pathmode:e cutmode:e its_milling_tolerances:r=TOLERANCES stepover:n
GENERAL_CLOSED_PROFILE placement:r=AXIS2_PLACEMENT_3D closed_profile_shape:r
GENERAL_OUTSIDE_PROFILE &F5 profile_swept_shape:r feature_boundary:r
GENERAL_PATH placement:r=AXIS2_PLACEMENT_3D swept_path:r
GENERAL_PATTERN &F4 replicate_base_feature:r replicate_locations:l
GENERAL_POCKET_BOTTOM_CONDITION shape:r
GENERAL_PROFILE placement:r=AXIS2_PLACEMENT_3D its_profile:r
GENERAL_PROFILE_FLOOR floor_radius:n start_or_end:e floor:r
GENERAL_SHAPE_PROFILE &F5 profile_swept_shape:r floor_condition:* removal_direction:r=DIRECTION profile_boundary:r
GEOMETRIC_REPRESENTATION_ITEM name:s
HELIX name:s position:r=AXIS2_PLACEMENT_3D radius:n pitch:n
HYPERBOLA name:s position:r=AXIS2_PLACEMENT_3D semi_axis:n semi_imag_axis:n
IF_STATEMENT its_id:s condition:r true_branch:r false_branch:r
INDEX_PALLET its_id:s its_index:n
INDEX_TABLE its_id:s its_index:n
IN_PROCESS_GEOMETRY as_is:r to_be:r removal:r
LEADING_LINE_STRATEGY pathmode:e cutmode:e its_milling_tolerances:r=TOLERANCES stepover:n its_line:r
LIMITS_AND_FITS deviation:n grade:n its_fitting_type:e
LINE name:s pnt:r=CARTESIAN_POINT dir:r=VECTOR
LINEAR_PATH placement:r=AXIS2_PLACEMENT_3D distance:r=TOLERANCED_LENGTH_MEASURE its_direction:r=DIRECTION
LINEAR_PROFILE placement:r=AXIS2_PLACEMENT_3D profile_length:r=NUMERIC_PARAMETER
LOAD_TOOL its_id:s its_tool:r
LOCAL_TIME hour_component:n minute_component:n second_component:n zone:r
LOOP name:s
LOOP_SLOT_END_TYPE
MACHINED_SURFACE its_machining_feature:r surface_element:e
MACHINING_FEATURE &F5
MACHINING_OPERATION &OP8
MACHINING_TOOL its_id:s
MACHINING_WORKINGSTEP its_id:s its_secplane:r its_feature:r its_operation:r its_effect:r
MANIFOLD_SOLID_BREP name:s outer:r
MANUFACTURING_FEATURE its_id:s its_workpiece:r=WORKPIECE its_operations:l
MATERIAL standard_identifier:s material_identifier:s material_property:l
MILLING_CUTTER &BODY
MILLING_CUTTING_TOOL its_id:s its_tool_body:r its_cutting_edge:l overall_assembly_length:n direction_for_spindle_orientation:r=DIRECTION tool_holder_diameter_for_spindle_orientation:n
MILLING_MACHINE_FUNCTIONS coolant:e coolant_pressure:n mist:e through_spindle_coolant:e through_pressure:n axis_clamping:l chip_removal:e oriented_spindle_stop:r=DIRECTION its_process_model:* other_functions:l
MILLING_MACHINING_OPERATION &OP8 overcut_length:n
MILLING_TECHNOLOGY feedrate:n feedrate_reference:e cutspeed:n spindle:n feedrate_per_tooth:n synchronize_spindle_with_feed:e inhibit_feedrate_override:e inhibit_spindle_override:e its_adaptive_control:e
MILLING_THREADING_TOOL &BODY
MILLING_TOOL_BODY &BODY
MILLING_TOOL_DIMENSION diameter:n tool_top_angle:n tool_circumference_angle:n cutting_edge_length:n edge_radius:n edge_center_vertical:n edge_center_horizontal:n
MILLING_TYPE_OPERATION &OP8 overcut_length:n approach:r retract:r
MULTIPLE_ARITY_BOOLEAN_EXPRESSION operands:l
MULTISTEP_DRILLING &DRI retract_distance:n first_depth:n depth_of_step:n dwell_time_step:n
NC_CONSTANT its_name:s initial_value:n
NC_FUNCTION its_id:s
NC_VARIABLE its_name:s initial_value:n
NGON_CLOSED_PROFILE placement:r=AXIS2_PLACEMENT_3D diameter:r=TOLERANCED_LENGTH_MEASURE number_of_sides:n circumscribed_or_across_flats:e
NGON_PROFILE placement:r=AXIS2_PLACEMENT_3D diameter:r=TOLERANCED_LENGTH_MEASURE number_of_sides:n circumscribed_or_across_flats:e
NON_SEQUENTIAL its_id:s its_elements:l
NOT_EXPRESSION operand:r
NUMERIC_PARAMETER parameter_name:s its_parameter_value:n its_parameter_unit:s
OFFSET_VECTOR translate:l rotate:l
OPEN_POCKET &F5 its_boss:l slope:n bottom_condition:r planar_radius:r=TOLERANCED_LENGTH_MEASURE orthogonal_radius:r=TOLERANCED_LENGTH_MEASURE open_boundary:r wall_boundary:r
OPEN_PROFILE placement:r=AXIS2_PLACEMENT_3D
OPEN_SHELL name:s cfs_faces:l
OPEN_SLOT_END_TYPE
OPERATION its_toolpath:r=TOOLPATH_LIST its_tool_direction:r
OPTIONAL_STOP its_id:s
ORDINAL_DATE year_component:n day_component:n
ORIENTED_EDGE name:s edge_start:r edge_end:r edge_element:r orientation:e
OR_EXPRESSION operands:l
PARABOLA name:s position:r=AXIS2_PLACEMENT_3D focal_dist:n
PARALLEL its_id:s branches:l
PARAMETERISED_PATH &TP
PARTIAL_AREA_DEFINITION effective_length:n placement:r=AXIS2_PLACEMENT_3D maximum_length:n
PARTIAL_CIRCULAR_PATH placement:r=AXIS2_PLACEMENT_3D radius:r=TOLERANCED_LENGTH_MEASURE sweep_angle:n
PARTIAL_CIRCULAR_PROFILE placement:r=AXIS2_PLACEMENT_3D radius:r=TOLERANCED_LENGTH_MEASURE sweep_angle:n
PARTIAL_CIRCULAR_SHAPE_PROFILE &F5 profile_swept_shape:r floor_condition:* removal_direction:r=DIRECTION open_boundary:r
PCURVE name:s basis_surface:r reference_to_curve:r
PERSON id:s last_name:* first_name:* middle_names:l prefix_titles:l suffix_titles:l
PERSON_AND_ADDRESS its_person:r its_address:r
PLACEMENT name:s location:r=CARTESIAN_POINT
PLANAR_FACE &F5 course_of_travel:r removal_boundary:r face_boundary:r its_boss:l
PLANAR_POCKET_BOTTOM_CONDITION
PLANAR_PROFILE_FLOOR floor_radius:n start_or_end:e floor:r
PLANE name:s position:r=AXIS2_PLACEMENT_3D
PLANE_CC_STRATEGY pathmode:e cutmode:e its_milling_tolerances:r=TOLERANCES stepover:n its_plane_normal:r=DIRECTION
PLANE_CL_STRATEGY pathmode:e cutmode:e its_milling_tolerances:r=TOLERANCES stepover:n its_plane_normal:r=DIRECTION
PLANE_FINISH_MILLING &MIL axial_cutting_depth:n allowance_bottom:n
PLANE_MILLING &MIL axial_cutting_depth:n allowance_bottom:n
PLANE_ROUGH_MILLING &MIL axial_cutting_depth:n allowance_bottom:n
PLUNGE_HELIX tool_orientation:r=DIRECTION radius:n angle:n
PLUNGE_RAMP tool_orientation:r=DIRECTION angle:n
PLUNGE_STRATEGY tool_orientation:r=DIRECTION
PLUNGE_TOOLAXIS tool_orientation:r=DIRECTION
PLUNGE_ZIGZAG tool_orientation:r=DIRECTION angle:n width:n
PLUS_MINUS_VALUE upper_limit:n lower_limit:n significant_digits:n
POCKET &F5 its_boss:l slope:n bottom_condition:r planar_radius:r=TOLERANCED_LENGTH_MEASURE orthogonal_radius:r=TOLERANCED_LENGTH_MEASURE
POINT name:s
POLYLINE name:s points:l
PROCESS_MODEL ini_data_file:s its_type:s
PROCESS_MODEL_LIST its_list:l
PROFILE placement:r=AXIS2_PLACEMENT_3D
PROFILE_FEATURE &F5 profile_swept_shape:r
PROFILE_FLOOR floor_radius:n start_or_end:e
PROGRAM_STOP its_id:s
PROGRAM_STRUCTURE its_id:s
PROJECT its_id:s main_workplan:r=WORKPLAN its_workpieces:l its_owner:r its_release:r its_status:r
PROPERTY_PARAMETER parameter_name:s
QUASI_UNIFORM_CURVE name:s degree:n control_points_list:l curve_form:e closed_curve:e self_intersect:e
QUASI_UNIFORM_SURFACE name:s u_degree:n v_degree:n control_points_list:l surface_form:e u_closed:e v_closed:e self_intersect:e
RADIUSED_POCKET_BOTTOM_CONDITION floor_radius_center:r=CARTESIAN_POINT floor_radius:r=TOLERANCED_LENGTH_MEASURE
RADIUSED_SLOT_END_TYPE
RAPID_MOVEMENT its_id:s its_secplane:r its_toolpath:r=TOOLPATH_LIST its_tool_direction:r
RATIONAL_BSPLINE_CURVE name:s degree:n control_points_list:l curve_form:e closed_curve:e self_intersect:e weights_data:l
RATIONAL_BSPLINE_SURFACE name:s u_degree:n v_degree:n control_points_list:l surface_form:e u_closed:e v_closed:e self_intersect:e weights_data:l
REAMER &BODY
REAMING &DRI spindle_stop_at_bottom:e depth_of_testcut:n waiting_position:r=CARTESIAN_POINT
RECTANGULAR_CLOSED_PROFILE placement:r=AXIS2_PLACEMENT_3D profile_width:r=TOLERANCED_LENGTH_MEASURE profile_length:r=TOLERANCED_LENGTH_MEASURE
RECTANGULAR_CLOSED_SHAPE_PROFILE &F5 profile_swept_shape:r floor_condition:* removal_direction:r=DIRECTION closed_boundary:r
RECTANGULAR_OFFSET offset_direction:r=DIRECTION offset_distance:n row_index:n column_index:n
RECTANGULAR_OMIT row_index:n column_index:n
RECTANGULAR_OPEN_SHAPE_PROFILE &F5 profile_swept_shape:r floor_condition:* removal_direction:r=DIRECTION open_boundary:r
RECTANGULAR_PATTERN &F4 replicate_base_feature:r spacing:r=TOLERANCED_LENGTH_MEASURE its_direction:r=DIRECTION number_of_rows:n number_of_columns:n row_spacing:r=TOLERANCED_LENGTH_MEASURE row_layout_direction:r=DIRECTION relocated_base_feature:l missing_base_feature:l
REGION &F4
REGION_PROJECTION &F4 proj_curve:r proj_dir:r=DIRECTION depth:r=TOLERANCED_LENGTH_MEASURE
REGION_SURFACE_LIST &F4 surface_list:l
REPLICATE_FEATURE &F4 replicate_base_feature:r
REPRESENTATION name:s items:l context_of_items:r
REPRESENTATION_CONTEXT context_identifier:s context_type:s
REPRESENTATION_ITEM name:s
RETURN_HOME its_id:s its_secplane:r its_toolpath:r=TOOLPATH_LIST its_tool_direction:r
RIGHT_CIRCULAR_CYLINDER name:s position:r height:n radius:n
ROUNDED_END &F5 course_of_travel:r partial_circular_boundary:r
ROUNDED_U_PROFILE placement:r=AXIS2_PLACEMENT_3D width:r=TOLERANCED_LENGTH_MEASURE
ROUND_HOLE &F5 diameter:r=TOLERANCED_LENGTH_MEASURE change_in_diameter:* bottom_condition:r
SELECTIVE its_id:s its_elements:l
SETUP its_id:s its_origin:r=AXIS2_PLACEMENT_3D its_secplane:r its_workpiece_setup:l
SETUP_INSTRUCTION description:* external_document:*
SET_MARK its_id:s
SHAPE_PROFILE &F5 profile_swept_shape:r floor_condition:* removal_direction:r=DIRECTION
SHAPE_REPRESENTATION name:s items:l context_of_items:r
SIDE_FINISH_MILLING &MIL axial_cutting_depth:n radial_cutting_depth:n allowance_side:n
SIDE_MILL &BODY length_measure:n
SIDE_MILLING &MIL axial_cutting_depth:n radial_cutting_depth:n allowance_side:n
SIDE_ROUGH_MILLING &MIL axial_cutting_depth:n radial_cutting_depth:n allowance_side:n
SLOT &F5 course_of_travel:r swept_shape:r end_conditions:l
SOLID_MODEL name:s
SPADE_DRILL &BODY
SPECIFICATION constraint:l specification_id:s specification_description:* specification_class:*
SPECIFICATION_USAGE_CONSTRAINT element:s class_id:s
SPHERICAL_CAP &F5 internal_angle:r=NUMERIC_PARAMETER radius:r=NUMERIC_PARAMETER
SPHERICAL_HOLE_BOTTOM radius:r=TOLERANCED_LENGTH_MEASURE
SPHERICAL_SURFACE name:s position:r=AXIS2_PLACEMENT_3D radius:n
SQUARE_U_PROFILE placement:r=AXIS2_PLACEMENT_3D width:r=TOLERANCED_LENGTH_MEASURE first_radius:r=TOLERANCED_LENGTH_MEASURE first_angle:n second_radius:r=TOLERANCED_LENGTH_MEASURE second_angle:n
STEP &F5 open_boundary:r wall_boundary:r its_boss:l
SURFACE name:s
SURFACE_OF_LINEAR_EXTRUSION name:s swept_curve:r extrusion_axis:r=VECTOR
SURFACE_OF_REVOLUTION name:s swept_curve:r axis_position:r
SURFACE_TEXTURE_PARAMETER its_value:n parameter_name:s measuring_method:s parameter_index:* applied_surfaces:l
SWEPT_SURFACE name:s swept_curve:r
TAP &BODY
TAPERED_DRILL &BODY taper_angle:n
TAPERED_ENDMILL &BODY taper_angle:n
TAPERED_REAMER &BODY taper_angle:n
TAPERED_TAP &BODY taper_angle:n
TAPPING &DRI compensation_chuck:e
TECHNOLOGY feedrate:n feedrate_reference:e
TEE_PROFILE placement:r=AXIS2_PLACEMENT_3D first_angle:n second_angle:n cross_bar_width:r=TOLERANCED_LENGTH_MEASURE cross_bar_depth:r=TOLERANCED_LENGTH_MEASURE radius:r=TOLERANCED_LENGTH_MEASURE width:r=TOLERANCED_LENGTH_MEASURE first_offset:r=TOLERANCED_LENGTH_MEASURE second_offset:r=TOLERANCED_LENGTH_MEASURE
THREAD &F5 partial_profile:* applied_shape:l inner_or_outer_thread:e qualifier:r fit_class:r form:r major_diameter:n number_of_threads:r=NUMERIC_PARAMETER thread_hand:r
THREAD_DRILLING &DRI helical_movement_on_forward:e
THREAD_MILL &BODY
THREE_AXES
THREE_AXES_TILTED_TOOL its_tool_direction:r=DIRECTION
THROUGH_BOTTOM_CONDITION
THROUGH_POCKET_BOTTOM_CONDITION
THROUGH_PROFILE_FLOOR
TOLERANCED_LENGTH_MEASURE theoretical_size:n implicit_tolerance:r
TOLERANCES chordal_tolerance:n scallop_height:n
TOOLPATH &TP
TOOLPATH_FEATURE &F5
TOOLPATH_LIST its_list:l
TOOLPATH_SPEED speed:r
TOOL_LENGTH_PROBING its_id:s its_secplane:r its_toolpath:r=TOOLPATH_LIST its_tool_direction:r measured_offset:r offset:r=CARTESIAN_POINT max_wear:n its_tool:r
TOOL_PROBING its_id:s its_secplane:r its_toolpath:r=TOOLPATH_LIST its_tool_direction:r measured_offset:r offset:r=CARTESIAN_POINT max_wear:n its_tool:r
TOOL_RADIUS_PROBING its_id:s its_secplane:r its_toolpath:r=TOOLPATH_LIST its_tool_direction:r measured_offset:r offset:r=CARTESIAN_POINT max_wear:n its_tool:r
TOPOLOGICAL_REGION &F4 name:s cfs_faces:l
TOPOLOGICAL_REPRESENTATION_ITEM name:s
TOUCH_PROBE its_id:s
TOUCH_PROBING its_id:s its_secplane:r its_toolpath:r=TOOLPATH_LIST its_tool_direction:r measured_offset:r
TRAJECTORY &TP its_direction:e
TRANSITION_FEATURE its_id:s its_workpiece:r=WORKPIECE its_operations:l first_feature:r second_feature:r
TRAVEL_PATH placement:r=AXIS2_PLACEMENT_3D
TRIMMED_CURVE name:s basis_curve:r trim_1:l trim_2:l sense_agreement:e master_representation:e
TWIST_DRILL &BODY
TWO_AXES
T_SLOT_MILL &BODY cutting_thickness:n
UNARY_BOOLEAN_EXPRESSION operand:r
UNIDIRECTIONAL overlap:n allow_multiple_passes:e feed_direction:r=DIRECTION cutmode:e
UNIDIRECTIONAL_MILLING overlap:n allow_multiple_passes:e feed_direction:r=DIRECTION cutmode:e
UNIFORM_CURVE name:s degree:n control_points_list:l curve_form:e closed_curve:e self_intersect:e
UNIFORM_SURFACE name:s u_degree:n v_degree:n control_points_list:l surface_form:e u_closed:e v_closed:e self_intersect:e
UNLOAD_TOOL its_id:s its_tool:r
USER_DEFINED_TOOL &BODY identifier:s
UV_STRATEGY pathmode:e cutmode:e its_milling_tolerances:r=TOLERANCES stepover:n forward_direction:r=DIRECTION sideward_direction:r=DIRECTION
VECTOR name:s orientation:r=DIRECTION magnitude:n
VEE_PROFILE placement:r=AXIS2_PLACEMENT_3D profile_radius:r=TOLERANCED_LENGTH_MEASURE profile_angle:n tilt_angle:n
VERTEX name:s
VIA_ARC_POINT name:s coordinates:l
VIA_HELIX_POINT name:s coordinates:l
VERTEX_LOOP name:s loop_vertex:r
VERTEX_POINT name:s vertex_geometry:r
WAIT_FOR_MARK its_id:s its_channel:r=CHANNEL
WEEK_OF_YEAR_AND_DAY_DATE year_component:n week_component:n day_component:n
WHILE_STATEMENT its_id:s condition:r body:r
WOODRUFF_KEYSEAT_MILL &BODY cutter_width:n
WOODRUFF_SLOT_END_TYPE radius:r=TOLERANCED_LENGTH_MEASURE
WORKINGSTEP its_id:s its_secplane:r
WORKPIECE its_id:s its_material:r=MATERIAL global_tolerance:n its_rawpiece:r=WORKPIECE its_geometry:r its_bounding_geometry:* clamping_positions:l
WORKPIECE_COMPLETE_PROBING its_id:s its_secplane:r its_toolpath:r=TOOLPATH_LIST its_tool_direction:r measured_offset:r its_workpiece:r=WORKPIECE probing_distance:r=TOLERANCED_LENGTH_MEASURE its_probe:r computed_offset:r
WORKPIECE_PROBING its_id:s its_secplane:r its_toolpath:r=TOOLPATH_LIST its_tool_direction:r measured_offset:r start_position:r=AXIS2_PLACEMENT_3D its_workpiece:r=WORKPIECE its_direction:r=DIRECTION expected_value:r=TOLERANCED_LENGTH_MEASURE its_probe:r
WORKPIECE_SETUP its_workpiece:r=WORKPIECE its_origin:r=AXIS2_PLACEMENT_3D its_offset:r its_restricted_area:* its_instructions:l
WORKPLAN its_id:s its_elements:l its_channel:r=CHANNEL its_setup:r=SETUP its_effect:r
XOR_EXPRESSION operand1:r operand2:r
"""

#: A line a supertype and its direct subtypes; of several supertypes of one entity the order is that of the lines.
SUBTYPES = """
EXECUTABLE NC_FUNCTION PROGRAM_STRUCTURE WORKINGSTEP
WORKINGSTEP MACHINING_WORKINGSTEP RAPID_MOVEMENT TOUCH_PROBING TURNING_WORKINGSTEP
RAPID_MOVEMENT RETURN_HOME
OPERATION RAPID_MOVEMENT MACHINING_OPERATION
TOUCH_PROBING TOOL_PROBING WORKPIECE_COMPLETE_PROBING WORKPIECE_PROBING
TOOL_PROBING TOOL_LENGTH_PROBING TOOL_RADIUS_PROBING
NC_FUNCTION DISPLAY_MESSAGE EXCHANGE_PALLET INDEX_PALLET INDEX_TABLE LOAD_TOOL OPTIONAL_STOP PROGRAM_STOP SET_MARK UNLOAD_TOOL WAIT_FOR_MARK
PROGRAM_STRUCTURE ASSIGNMENT IF_STATEMENT NON_SEQUENTIAL PARALLEL SELECTIVE WHILE_STATEMENT WORKPLAN
MACHINING_OPERATION MILLING_MACHINING_OPERATION TURNING_MACHINING_OPERATION
MILLING_MACHINING_OPERATION DRILLING_TYPE_OPERATION MILLING_TYPE_OPERATION
MILLING_TYPE_OPERATION FREEFORM_OPERATION TWO5D_MILLING_OPERATION
TWO5D_MILLING_OPERATION BOTTOM_AND_SIDE_MILLING PLANE_MILLING SIDE_MILLING
BOTTOM_AND_SIDE_MILLING BOTTOM_AND_SIDE_FINISH_MILLING BOTTOM_AND_SIDE_ROUGH_MILLING
PLANE_MILLING PLANE_FINISH_MILLING PLANE_ROUGH_MILLING
SIDE_MILLING SIDE_FINISH_MILLING SIDE_ROUGH_MILLING
DRILLING_TYPE_OPERATION BACK_BORING BORING_OPERATION DRILLING_OPERATION TAPPING THREAD_DRILLING
BORING_OPERATION BORING REAMING
DRILLING_OPERATION CENTER_DRILLING COUNTER_SINKING DRILLING MULTISTEP_DRILLING
TURNING_MACHINING_OPERATION CONTOURING FACING GROOVING KNURLING THREADING
CONTOURING CONTOURING_FINISH CONTOURING_ROUGH
FACING FACING_FINISH FACING_ROUGH
GROOVING CUTTING_IN GROOVING_FINISH GROOVING_ROUGH
THREADING THREADING_FINISH THREADING_ROUGH
TECHNOLOGY MILLING_TECHNOLOGY TURNING_TECHNOLOGY
MACHINE_FUNCTIONS MILLING_MACHINE_FUNCTIONS TURNING_MACHINE_FUNCTIONS
TOOLPATH FEEDSTOP PARAMETERISED_PATH TRAJECTORY
TRAJECTORY AXIS_TRAJECTORY CUTTER_CONTACT_TRAJECTORY CUTTER_LOCATION_TRAJECTORY
PARAMETERISED_PATH APPROACH_LIFT_PATH CONNECTOR
APPROACH_LIFT_PATH AP_LIFT_PATH_ANGLE AP_LIFT_PATH_TANGENT
CONNECTOR CONNECT_DIRECT CONNECT_SECPLANE
TOOL_DIRECTION TOOL_DIRECTION_FOR_MILLING TWO_AXES
TOOL_DIRECTION_FOR_MILLING FIVE_AXES_CONST_TILT_YAW FIVE_AXES_VAR_TILT_YAW THREE_AXES THREE_AXES_TILTED_TOOL TWO_AXES
TWO5D_MILLING_STRATEGY BIDIRECTIONAL BIDIRECTIONAL_CONTOUR BIDIRECTIONAL_MILLING CENTER_MILLING CONTOUR_BIDIRECTIONAL
TWO5D_MILLING_STRATEGY CONTOUR_PARALLEL CONTOUR_SPIRAL EXPLICIT EXPLICIT_STRATEGY UNIDIRECTIONAL UNIDIRECTIONAL_MILLING
FREEFORM_STRATEGY LEADING_LINE_STRATEGY PLANE_CC_STRATEGY PLANE_CL_STRATEGY UV_STRATEGY
APPROACH_RETRACT_STRATEGY AIR_STRATEGY ALONG_PATH PLUNGE_STRATEGY
AIR_STRATEGY AP_RETRACT_ANGLE AP_RETRACT_TANGENT
PLUNGE_STRATEGY PLUNGE_HELIX PLUNGE_RAMP PLUNGE_TOOLAXIS PLUNGE_ZIGZAG
MANUFACTURING_FEATURE REGION TRANSITION_FEATURE TWO5D_MANUFACTURING_FEATURE
TWO5D_MANUFACTURING_FEATURE COMPOUND_FEATURE MACHINING_FEATURE REPLICATE_FEATURE
MACHINING_FEATURE BOSS PLANAR_FACE POCKET PROFILE_FEATURE ROUNDED_END ROUND_HOLE SLOT SPHERICAL_CAP STEP THREAD TOOLPATH_FEATURE
COMPOUND_FEATURE COUNTERBORE_HOLE COUNTERSUNK_HOLE
POCKET CLOSED_POCKET OPEN_POCKET
PROFILE_FEATURE GENERAL_OUTSIDE_PROFILE SHAPE_PROFILE
SHAPE_PROFILE CIRCULAR_CLOSED_SHAPE_PROFILE GENERAL_SHAPE_PROFILE PARTIAL_CIRCULAR_SHAPE_PROFILE
SHAPE_PROFILE RECTANGULAR_CLOSED_SHAPE_PROFILE RECTANGULAR_OPEN_SHAPE_PROFILE
THREAD CATALOGUE_THREAD DEFINED_THREAD
REPLICATE_FEATURE CIRCULAR_PATTERN GENERAL_PATTERN RECTANGULAR_PATTERN
REGION REGION_PROJECTION REGION_SURFACE_LIST TOPOLOGICAL_REGION
TRANSITION_FEATURE CHAMFER EDGE_ROUND
PROFILE CLOSED_PROFILE OPEN_PROFILE
CLOSED_PROFILE CIRCULAR_CLOSED_PROFILE GENERAL_CLOSED_PROFILE NGON_CLOSED_PROFILE NGON_PROFILE RECTANGULAR_CLOSED_PROFILE
OPEN_PROFILE GENERAL_PROFILE LINEAR_PROFILE PARTIAL_CIRCULAR_PROFILE ROUNDED_U_PROFILE SQUARE_U_PROFILE TEE_PROFILE VEE_PROFILE
TRAVEL_PATH CIRCULAR_PATH COMPLETE_CIRCULAR_PATH GENERAL_PATH LINEAR_PATH PARTIAL_CIRCULAR_PATH
CIRCULAR_PATH COMPLETE_CIRCULAR_PATH PARTIAL_CIRCULAR_PATH
HOLE_BOTTOM_CONDITION BLIND_BOTTOM_CONDITION THROUGH_BOTTOM_CONDITION
BLIND_BOTTOM_CONDITION CONICAL_HOLE_BOTTOM FLAT_HOLE_BOTTOM FLAT_WITH_RADIUS_HOLE_BOTTOM SPHERICAL_HOLE_BOTTOM
POCKET_BOTTOM_CONDITION GENERAL_POCKET_BOTTOM_CONDITION PLANAR_POCKET_BOTTOM_CONDITION
POCKET_BOTTOM_CONDITION RADIUSED_POCKET_BOTTOM_CONDITION THROUGH_POCKET_BOTTOM_CONDITION
SLOT_END_TYPE FLAT_SLOT_END_TYPE LOOP_SLOT_END_TYPE OPEN_SLOT_END_TYPE RADIUSED_SLOT_END_TYPE WOODRUFF_SLOT_END_TYPE
PROFILE_FLOOR GENERAL_PROFILE_FLOOR PLANAR_PROFILE_FLOOR
TAPER_SELECT ANGLE_TAPER DIAMETER_TAPER
TOLERANCE_SELECT LIMITS_AND_FITS PLUS_MINUS_VALUE
PROPERTY_PARAMETER DESCRIPTIVE_PARAMETER NUMERIC_PARAMETER
MACHINING_TOOL CUTTING_TOOL TOUCH_PROBE
CUTTING_TOOL MILLING_CUTTING_TOOL
TOOL_BODY MILLING_TOOL_BODY
MILLING_TOOL_BODY BACKSIDE_COUNTERBORE BACKSIDE_COUNTERSINK BORING_TOOL CENTER_DRILL COUNTERBORE COUNTERSINK DRILL
MILLING_TOOL_BODY MILLING_CUTTER MILLING_THREADING_TOOL REAMER USER_DEFINED_TOOL
COUNTERBORE BACKSIDE_COUNTERBORE
COUNTERSINK BACKSIDE_COUNTERSINK
DRILL COMBINED_DRILL_AND_REAMER COMBINED_DRILL_AND_TAP DOVETAIL_MILL SPADE_DRILL TAPERED_DRILL TWIST_DRILL
TWIST_DRILL COMBINED_DRILL_AND_REAMER COMBINED_DRILL_AND_TAP TAPERED_DRILL
MILLING_CUTTER BALL_ENDMILL BULLNOSE_ENDMILL DOVETAIL_MILL ENDMILL FACEMILL SIDE_MILL T_SLOT_MILL TAPERED_ENDMILL WOODRUFF_KEYSEAT_MILL
ENDMILL BALL_ENDMILL BULLNOSE_ENDMILL TAPERED_ENDMILL
MILLING_THREADING_TOOL TAP THREAD_MILL
TAP COMBINED_DRILL_AND_TAP TAPERED_TAP
REAMER TAPERED_REAMER
REPRESENTATION_ITEM GEOMETRIC_REPRESENTATION_ITEM TOPOLOGICAL_REPRESENTATION_ITEM
GEOMETRIC_REPRESENTATION_ITEM BLOCK CURVE DIRECTION EDGE_CURVE FACE_SURFACE PLACEMENT POINT RIGHT_CIRCULAR_CYLINDER SOLID_MODEL
GEOMETRIC_REPRESENTATION_ITEM SURFACE VECTOR VERTEX_POINT
POINT CARTESIAN_POINT
CARTESIAN_POINT VIA_ARC_POINT VIA_HELIX_POINT
PLACEMENT AXIS1_PLACEMENT AXIS2_PLACEMENT_3D
CURVE BOUNDED_CURVE BOUNDED_PCURVE CONIC HELIX LINE PCURVE
CONIC CIRCLE ELLIPSE HYPERBOLA PARABOLA
BOUNDED_CURVE B_SPLINE_CURVE COMPOSITE_CURVE POLYLINE TRIMMED_CURVE
B_SPLINE_CURVE BEZIER_CURVE B_SPLINE_CURVE_WITH_KNOTS QUASI_UNIFORM_CURVE RATIONAL_B_SPLINE_CURVE UNIFORM_CURVE
FOUNDED_ITEM COMPOSITE_CURVE_SEGMENT
SURFACE BOUNDED_SURFACE ELEMENTARY_SURFACE
BOUNDED_SURFACE B_SPLINE_SURFACE
B_SPLINE_SURFACE BEZIER_SURFACE B_SPLINE_SURFACE_WITH_KNOTS
ELEMENTARY_SURFACE CONICAL_SURFACE CYLINDRICAL_SURFACE PLANE SPHERICAL_SURFACE TOROIDAL_SURFACE
SOLID_MODEL MANIFOLD_SOLID_BREP
TOPOLOGICAL_REPRESENTATION_ITEM CONNECTED_FACE_SET EDGE FACE FACE_BOUND LOOP VERTEX
CONNECTED_FACE_SET CLOSED_SHELL OPEN_SHELL
EDGE EDGE_CURVE ORIENTED_EDGE
FACE FACE_SURFACE
FACE_SURFACE ADVANCED_FACE
FACE_BOUND FACE_OUTER_BOUND
LOOP EDGE_LOOP POLY_LOOP
VERTEX VERTEX_POINT
PATH EDGE_LOOP
"""
