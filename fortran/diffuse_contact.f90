!> The diffuse contact element for Fortran: the C library's interface, see diffuse_contact.h for what each call does.
!!
!! Names and arguments are those of C. Handles are type(c_ptr). Indices of nodes and slaves count from 0, as in C. Arguments that may
!! be NULL in C are optional. dc_text() is dc_message() as a Fortran string.
module diffuse_contact
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_f_pointer, c_funptr, c_int, c_int32_t, c_int64_t, c_null_funptr, &
        c_null_ptr, c_ptr, c_size_t
    implicit none
    public

    private :: c_char, c_double, c_f_pointer, c_funptr, c_int, c_int32_t, c_int64_t, c_null_funptr, c_null_ptr, &
        c_ptr, c_size_t, length_of

    ! dc_status
    enum, bind(c)
        enumerator :: DC_OK = 0, DC_FROZEN, DC_NO_CONTACT, DC_BAD_POINTER, DC_BAD_SIZE, DC_BAD_HANDLE, DC_BUSY, &
            DC_BAD_OPTION, DC_NOT_FINITE, DC_OUT_OF_RANGE, DC_BAD_SURFACE, DC_BAD_SLAVES, DC_NOT_EVALUATED, &
            DC_PATTERN_MISMATCH, DC_OVERFLOW, DC_TOO_LARGE, DC_INTERNAL
    end enum

    ! dc_outcome
    enum, bind(c)
        enumerator :: DC_CONTACT = 0, DC_NOT_PAIRED, DC_TOO_FAR, DC_NO_CANDIDATE, DC_ILL_CONDITIONED, DC_BEYOND_BORDER, &
            DC_SINGULAR_FIT, DC_FOOT_DIVERGED, DC_FOOT_OUTSIDE, DC_CENTRE_OF_CURVATURE, &
            DC_BEYOND_CENTRE_OF_CURVATURE, DC_NO_AVERAGE_PLANE, DC_AMBIGUOUS_OUTWARD, DC_DEGENERATE_FACET, &
            DC_ELEMENT_OVERFLOW, DC_REFUSED, DC_NOT_MATERIAL_PLACE, DC_BEYOND_WINDOW, &
            DC_NOTHING_OVER
    end enum

    ! dc_fallback, dc_mode, dc_element_kind, dc_weight, dc_frame, dc_rule, dc_basis, dc_tangent, dc_triangle
    enum, bind(c)
        enumerator :: DC_NO_FALLBACK = 0, DC_EXTENDED, DC_LINEAR_BASIS
        enumerator :: DC_VALUE = 0, DC_GRADIENT, DC_HESSIAN
        enumerator :: DC_DIFFUSE = 0, DC_NODE_TO_FACET
        enumerator :: DC_CUBIC = 0, DC_CUBIC_INTERPOLATING, DC_WENDLAND_C2
        enumerator :: DC_CO_MOVING = 0, DC_HELD, DC_GIVEN
        enumerator :: DC_HULL_LAYERS = 0, DC_HULL_RADIUS, DC_NEAREST, DC_DOMAINS
        enumerator :: DC_LINEAR = 1, DC_QUADRATIC
        enumerator :: DC_OPEN = 0, DC_STICK, DC_SLIP
        enumerator :: DC_CONSTANT = 0, DC_DECAYING, DC_TABULATED, DC_FUNCTION
        enumerator :: DC_EXACT = 0, DC_GAUSS_NEWTON
        enumerator :: DC_NODE_PRESSURES = 0, DC_POINT_PRESSURES
        enumerator :: DC_FULL = 0, DC_LOWER
    end enum

    !> How an interface pairs and evaluates. The values here are zeros: call dc_options_default first.
    type, bind(c) :: dc_options
        integer(c_size_t) :: size = 112
        integer(c_int32_t) :: element = 0, weight = 0, frame = 0, rule = 0, layers = 0, max_layers = 0, nearest = 0, &
            max_nearest = 0, candidates = 0, max_candidates = 0, basis = 0, linear_fallback = 0, areas = 0, &
            reserved = 0
        real(c_double) :: smallest_regularity = 0, radius_factor = 0, feature_angle_degrees = 0, border_tolerance = 0, &
            distance_limit = 0, cutback_penetration = 0
    end type

    !> What a refresh did, in numbers of slaves.
    type, bind(c) :: dc_report
        integer(c_size_t) :: size = 104
        integer(c_int32_t) :: paired = 0, kept = 0, renewed = 0, changed = 0, gained = 0, lost = 0, without = 0, &
            extended = 0, linear = 0, contacts_lost = 0, contacts_gained = 0, jump_node = -1, lost_node = -1, &
            gained_node = -1
        real(c_double) :: jump_before = 0, jump_after = 0, lost_gap = 0, gained_gap = 0
        integer(c_int32_t) :: rebuilt = 0, deep = 0
    end type

    !> What the cutting of the faces gave.
    type, bind(c) :: dc_faces_report
        integer(c_size_t) :: size = 32
        integer(c_int32_t) :: points = 0, paired = 0, faces = 0, straight = 0, grown = 0, reserved = 0
    end type

    !> The contact of one slave.
    type, bind(c) :: dc_contact_data
        integer(c_int32_t) :: node = 0, master_count = 0, outcome = 0, fallback = 0
        real(c_double) :: gap = 0, foot(3) = 0, normal(3) = 0, area = 0, support_radius = 0
    end type

    !> The law of contact. Arrays are c_loc of them, or c_null_ptr, functions c_funloc; friction is the coefficient, 0 for none.
    type, bind(c) :: dc_law
        integer(c_size_t) :: size = 184
        real(c_double) :: penalty = 0
        type(c_ptr) :: multipliers = c_null_ptr
        integer(c_size_t) :: multiplier_count = 0
        integer(c_int32_t) :: tangent = DC_EXACT, reserved = 0
        real(c_double) :: friction = 0, tangential_stiffness = 0, shear_limit = 0
        integer(c_int32_t) :: coefficient = DC_CONSTANT, augmented = 0
        type(c_ptr) :: normal_gaps = c_null_ptr, normal_pressures = c_null_ptr
        integer(c_size_t) :: normal_count = 0
        real(c_double) :: duration = 0, friction_in_motion = 0, friction_decay = 0
        type(c_ptr) :: friction_pressures = c_null_ptr
        integer(c_size_t) :: friction_pressure_count = 0
        type(c_ptr) :: friction_rates = c_null_ptr
        integer(c_size_t) :: friction_rate_count = 0
        type(c_ptr) :: friction_table = c_null_ptr
        type(c_funptr) :: normal_law = c_null_funptr, friction_law = c_null_funptr
        type(c_ptr) :: context = c_null_ptr
    end type

    !> What stays fixed for one slave until it is paired anew.
    type, bind(c) :: dc_pairing
        integer(c_size_t) :: size = 56
        integer(c_int32_t) :: master_count = 0, basis = 0, fallback = 0, encloses_slave = 0
        real(c_double) :: support_radius = 0, normal(3) = 0
    end type

    !> What one element is besides its nodes.
    type, bind(c) :: dc_element
        integer(c_size_t) :: size = 128
        integer(c_int32_t) :: basis = 0, weight = DC_CUBIC, frame = DC_CO_MOVING, reserved = 0
        real(c_double) :: support_radius = 0, outward(3) = 0, t1(3) = 0, t2(3) = 0, normal(3) = 0
    end type

    !> Where an element touches.
    type, bind(c) :: dc_point
        integer(c_int32_t) :: outcome = 0, reserved = 0
        real(c_double) :: gap = 0, foot(3) = 0, normal(3) = 0
    end type

    interface
        function dc_status_name(status) bind(c) result(text)
            import :: c_int32_t, c_ptr
            integer(c_int32_t), value :: status
            type(c_ptr) :: text
        end function

        function dc_message() bind(c) result(text)
            import :: c_ptr
            type(c_ptr) :: text
        end function

        function dc_outcome_code(outcome) bind(c) result(text)
            import :: c_int32_t, c_ptr
            integer(c_int32_t), value :: outcome
            type(c_ptr) :: text
        end function

        function dc_set_threads(count) bind(c) result(status)
            import :: c_int, c_int32_t
            integer(c_int32_t), value :: count
            integer(c_int) :: status
        end function

        function dc_thread_count() bind(c) result(count)
            import :: c_size_t
            integer(c_size_t) :: count
        end function

        function dc_version() bind(c) result(text)
            import :: c_ptr
            type(c_ptr) :: text
        end function

        function dc_isa() bind(c) result(text)
            import :: c_ptr
            type(c_ptr) :: text
        end function

        !> name ends with c_null_char.
        function dc_set_isa(name) bind(c) result(status)
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: name(*)
            integer(c_int) :: status
        end function

        function dc_options_default(options) bind(c) result(status)
            import :: c_int, dc_options
            type(dc_options), intent(inout) :: options
            integer(c_int) :: status
        end function

        function dc_create(positions, node_count, facets, facet_count, slaves, slave_count, slave_facets, &
                slave_facet_count, options, interface) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t, dc_options
            real(c_double), intent(in) :: positions(*)
            integer(c_int32_t), intent(in) :: facets(*), slaves(*)
            integer(c_int32_t), intent(in), optional :: slave_facets(*)
            integer(c_size_t), value :: node_count, facet_count, slave_count, slave_facet_count
            type(dc_options), intent(in), optional :: options
            type(c_ptr), intent(out) :: interface
            integer(c_int) :: status
        end function

        function dc_create_self_contact(positions, node_count, facets, facet_count, options, interface) bind(c) &
                result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t, dc_options
            real(c_double), intent(in) :: positions(*)
            integer(c_int32_t), intent(in) :: facets(*)
            integer(c_size_t), value :: node_count, facet_count
            type(dc_options), intent(in), optional :: options
            type(c_ptr), intent(out) :: interface
            integer(c_int) :: status
        end function

        function dc_destroy(interface) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: interface
            integer(c_int) :: status
        end function

        function dc_counts(interface, node_count, slave_count) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: interface
            integer(c_size_t), intent(out), optional :: node_count, slave_count
            integer(c_int) :: status
        end function

        !> The slave nodes, in the order of results and multipliers; ascending for a surface in contact with itself.
        function dc_slaves(interface, slaves, slave_count) bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: interface
            integer(c_int32_t), intent(inout) :: slaves(*)
            integer(c_size_t), value :: slave_count
            integer(c_int) :: status
        end function

        !> planes: six numbers each, a point and the unit normal to the side of the model. With other planes than before the history of
        !! friction ends: dc_set_history comes after it.
        function dc_set_symmetry(interface, planes, plane_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: interface
            real(c_double), intent(in), optional :: planes(*)
            integer(c_size_t), value :: plane_count
            integer(c_int) :: status
        end function

        function dc_update(interface, positions, node_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: interface
            real(c_double), intent(in) :: positions(*)
            integer(c_size_t), value :: node_count
            integer(c_int) :: status
        end function

        function dc_follow(interface, positions, node_count, rebuilt) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: interface
            real(c_double), intent(in) :: positions(*)
            integer(c_size_t), value :: node_count
            integer(c_int32_t), intent(out), optional :: rebuilt
            integer(c_int) :: status
        end function

        function dc_refresh(interface, positions, node_count, report) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t, dc_report
            type(c_ptr), value :: interface
            real(c_double), intent(in) :: positions(*)
            integer(c_size_t), value :: node_count
            type(dc_report), intent(inout), optional :: report
            integer(c_int) :: status
        end function

        function dc_renew(interface, positions, node_count, report) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t, dc_report
            type(c_ptr), value :: interface
            real(c_double), intent(in) :: positions(*)
            integer(c_size_t), value :: node_count
            type(dc_report), intent(inout), optional :: report
            integer(c_int) :: status
        end function

        function dc_freeze(interface) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: interface
            integer(c_int) :: status
        end function

        function dc_thaw(interface) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: interface
            integer(c_int) :: status
        end function

        function dc_evaluate(interface, mode) bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr
            type(c_ptr), value :: interface
            integer(c_int32_t), value :: mode
            integer(c_int) :: status
        end function

        function dc_set_equations(interface, equations, node_count, equation_count) bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: interface
            integer(c_int32_t), intent(in), optional :: equations(*)
            integer(c_size_t), value :: node_count, equation_count
            integer(c_int) :: status
        end function

        function dc_contact_of(interface, slave, contact) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t, dc_contact_data
            type(c_ptr), value :: interface
            integer(c_size_t), value :: slave
            type(dc_contact_data), intent(out) :: contact
            integer(c_int) :: status
        end function

        function dc_derivatives(interface, slave, nodes, node_size, gradient, gradient_size, hessian, hessian_size) &
                bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: interface
            integer(c_size_t), value :: slave, node_size, gradient_size, hessian_size
            integer(c_int32_t), intent(inout), optional :: nodes(*)
            real(c_double), intent(inout), optional :: gradient(*), hessian(*)
            integer(c_int) :: status
        end function

        function dc_feet(interface, outcomes, slave_count, weights, weight_size, foot, foot_size, normal, normal_size) &
                bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: interface
            integer(c_int32_t), intent(inout), optional :: outcomes(*)
            integer(c_size_t), value :: slave_count, weight_size, foot_size, normal_size
            real(c_double), intent(inout), optional :: weights(*), foot(*), normal(*)
            integer(c_int) :: status
        end function

        function dc_gaps(interface, outcomes, gaps, slave_count) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: interface
            integer(c_int32_t), intent(inout), optional :: outcomes(*)
            real(c_double), intent(inout), optional :: gaps(*)
            integer(c_size_t), value :: slave_count
            integer(c_int) :: status
        end function

        function dc_forces(interface, law, penetrations, forces, pressures, slave_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: interface
            type(dc_law), intent(in) :: law
            real(c_double), intent(inout), optional :: penetrations(*), forces(*), pressures(*)
            integer(c_size_t), value :: slave_count
            integer(c_int) :: status
        end function

        function dc_cutback(interface, factor) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            type(c_ptr), value :: interface
            real(c_double), intent(out) :: factor
            integer(c_int) :: status
        end function

        !> With friction: the positions of the moment are the end of an increment.
        function dc_accept(interface, law, stuck_count, sliding_count, unanchored_count, dropped_count, dissipated) &
                bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: interface
            type(dc_law), intent(in) :: law
            integer(c_size_t), intent(out), optional :: stuck_count, sliding_count, unanchored_count, dropped_count
            real(c_double), intent(out), optional :: dissipated
            integer(c_int) :: status
        end function

        !> A round of the augmented Lagrangian for friction, in equilibrium.
        function dc_augment(interface, law, moves, slave_count) bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: interface
            type(dc_law), intent(in) :: law
            integer(c_int32_t), intent(in), optional :: moves(*)
            integer(c_size_t), value :: slave_count
            integer(c_int) :: status
        end function

        function dc_slip_errors(interface, law, errors, slave_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: interface
            type(dc_law), intent(in) :: law
            real(c_double), intent(inout) :: errors(*)
            integer(c_size_t), value :: slave_count
            integer(c_int) :: status
        end function

        function dc_roll_back(interface) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: interface
            integer(c_int) :: status
        end function

        !> Friction of all slaves, before dc_accept; tractions on the slave.
        function dc_friction(interface, law, states, tractions, slips, slave_count) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: interface
            type(dc_law), intent(in) :: law
            integer(c_int32_t), intent(inout), optional :: states(*)
            real(c_double), intent(inout), optional :: tractions(*), slips(*)
            integer(c_size_t), value :: slave_count
            integer(c_int) :: status
        end function

        !> Numbers for a restart; without history count gets how many there are.
        function dc_history(interface, history, capacity, count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: interface
            real(c_double), intent(inout), optional :: history(*)
            integer(c_size_t), value :: capacity
            integer(c_size_t), intent(out) :: count
            integer(c_int) :: status
        end function

        function dc_augmented_history(interface, history, capacity, count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: interface
            real(c_double), intent(inout), optional :: history(*)
            integer(c_size_t), value :: capacity
            integer(c_size_t), intent(out) :: count
            integer(c_int) :: status
        end function

        function dc_set_history(interface, history, count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: interface
            real(c_double), intent(in), optional :: history(*)
            integer(c_size_t), value :: count
            integer(c_int) :: status
        end function

        !> The tangent of a law, DC_EXACT or DC_GAUSS_NEWTON, by the norms of the residual and of the largest forces.
        function dc_adaptive_tangent(residual, force) bind(c) result(tangent)
            import :: c_double, c_int32_t
            real(c_double), value :: residual, force
            integer(c_int32_t) :: tangent
        end function

        function dc_add_forces(interface, law, forces, equation_count, active_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: interface
            type(dc_law), intent(in) :: law
            real(c_double), intent(inout) :: forces(*)
            integer(c_size_t), value :: equation_count
            integer(c_size_t), intent(out), optional :: active_count
            integer(c_int) :: status
        end function

        function dc_triplets(interface, law, triangle, rows, columns, values, capacity, count) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: interface
            type(dc_law), intent(in) :: law
            integer(c_int32_t), value :: triangle
            integer(c_int32_t), intent(inout), optional :: rows(*), columns(*)
            real(c_double), intent(inout), optional :: values(*)
            integer(c_size_t), value :: capacity
            integer(c_size_t), intent(out) :: count
            integer(c_int) :: status
        end function

        function dc_window_create(interface, boxes, box_count, skin, window) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: interface
            real(c_double), intent(in) :: boxes(*)
            integer(c_size_t), value :: box_count
            real(c_double), value :: skin
            type(c_ptr), intent(out) :: window
            integer(c_int) :: status
        end function

        function dc_window_destroy(window) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: window
            integer(c_int) :: status
        end function

        function dc_window_counts(window, node_count, facet_count, integer_count, real_count) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: window
            integer(c_size_t), intent(out), optional :: node_count, facet_count, integer_count, real_count
            integer(c_int) :: status
        end function

        function dc_window_names(window, nodes, node_count, facets, facet_count) bind(c) result(status)
            import :: c_int, c_int64_t, c_ptr, c_size_t
            type(c_ptr), value :: window
            integer(c_int64_t), intent(out), optional :: nodes(*), facets(*)
            integer(c_size_t), value :: node_count, facet_count
            integer(c_int) :: status
        end function

        function dc_window_numbers(window, integers, integer_count, reals, real_count) bind(c) result(status)
            import :: c_double, c_int, c_int64_t, c_ptr, c_size_t
            type(c_ptr), value :: window
            integer(c_int64_t), intent(out) :: integers(*)
            integer(c_size_t), value :: integer_count, real_count
            real(c_double), intent(out) :: reals(*)
            integer(c_int) :: status
        end function

        function dc_window_from_numbers(integers, integer_count, reals, real_count, window) bind(c) result(status)
            import :: c_double, c_int, c_int64_t, c_ptr, c_size_t
            integer(c_int64_t), intent(in) :: integers(*)
            integer(c_size_t), value :: integer_count, real_count
            real(c_double), intent(in) :: reals(*)
            type(c_ptr), intent(out) :: window
            integer(c_int) :: status
        end function

        function dc_extents(positions, node_count, facets, facet_count, extents) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_size_t
            real(c_double), intent(in) :: positions(*)
            integer(c_int32_t), intent(in) :: facets(*)
            integer(c_size_t), value :: node_count, facet_count
            real(c_double), intent(out) :: extents(*)
            integer(c_int) :: status
        end function

        function dc_boxes_around(positions, point_count, reach, most, boxes, box_count) bind(c) result(status)
            import :: c_double, c_int, c_size_t
            real(c_double), intent(in) :: positions(*)
            integer(c_size_t), value :: point_count, most
            real(c_double), value :: reach
            real(c_double), intent(out) :: boxes(*)
            integer(c_size_t), intent(out) :: box_count
            integer(c_int) :: status
        end function

        function dc_part_create(positions, node_names, node_count, facets, facet_names, owned, facet_count, known, extents, &
                planes, plane_count, options, part) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_int64_t, c_ptr, c_size_t, dc_options
            real(c_double), intent(in) :: positions(*), known(*), extents(*)
            integer(c_int64_t), intent(in) :: node_names(*), facet_names(*)
            integer(c_int32_t), intent(in) :: facets(*), owned(*)
            real(c_double), intent(in), optional :: planes(*)
            integer(c_size_t), value :: node_count, facet_count, plane_count
            type(dc_options), intent(in), optional :: options
            type(c_ptr), intent(out) :: part
            integer(c_int) :: status
        end function

        function dc_part_destroy(part) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: part
            integer(c_int) :: status
        end function

        function dc_part_demands(part, integers, integer_capacity, integer_count, reals, real_capacity, real_count) bind(c) &
                result(status)
            import :: c_double, c_int, c_int64_t, c_ptr, c_size_t
            type(c_ptr), value :: part
            integer(c_int64_t), intent(out), optional :: integers(*)
            real(c_double), intent(out), optional :: reals(*)
            integer(c_size_t), value :: integer_capacity, real_capacity
            integer(c_size_t), intent(out), optional :: integer_count, real_count
            integer(c_int) :: status
        end function

        function dc_part_settle(part, integers, integer_count, reals, real_count, is_settled) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_int64_t, c_ptr, c_size_t
            type(c_ptr), value :: part
            integer(c_int64_t), intent(in) :: integers(*)
            real(c_double), intent(in) :: reals(*)
            integer(c_size_t), value :: integer_count, real_count
            integer(c_int32_t), intent(out) :: is_settled
            integer(c_int) :: status
        end function

        function dc_part_window(part, positions, node_count, boxes, box_count, skin, window) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: part
            real(c_double), intent(in) :: positions(*), boxes(*)
            integer(c_size_t), value :: node_count, box_count
            real(c_double), value :: skin
            type(c_ptr), intent(out) :: window
            integer(c_int) :: status
        end function

        function dc_window_joined(windows, window_count, joined) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), intent(in) :: windows(*)
            integer(c_size_t), value :: window_count
            type(c_ptr), intent(out) :: joined
            integer(c_int) :: status
        end function

        function dc_window_first_positions(window, positions, node_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: window
            real(c_double), intent(out) :: positions(*)
            integer(c_size_t), value :: node_count
            integer(c_int) :: status
        end function

        function dc_history_lengths(history, count, lengths, capacity, part_count) bind(c) result(status)
            import :: c_double, c_int, c_size_t
            real(c_double), intent(in) :: history(*)
            integer(c_size_t), value :: count, capacity
            integer(c_size_t), intent(out), optional :: lengths(*)
            integer(c_size_t), intent(out) :: part_count
            integer(c_int) :: status
        end function

        !> The window's nodes are where they were when it was made. For areas slaves, and the other nodes of slave_facets, are in their first
        !! positions, also in a later increment.
        function dc_create_in_window(window, positions, node_count, slaves, slave_count, slave_facets, slave_facet_count, &
                options, interface) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t, dc_options
            type(c_ptr), value :: window
            real(c_double), intent(in) :: positions(*)
            integer(c_int32_t), intent(in) :: slaves(*)
            integer(c_int32_t), intent(in), optional :: slave_facets(*)
            integer(c_size_t), value :: node_count, slave_count, slave_facet_count
            type(dc_options), intent(in), optional :: options
            type(c_ptr), intent(out) :: interface
            integer(c_int) :: status
        end function

        function dc_pattern_create(interface, pattern, entry_count) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: interface
            type(c_ptr), intent(out) :: pattern
            integer(c_size_t), intent(out), optional :: entry_count
            integer(c_int) :: status
        end function

        function dc_pattern_destroy(pattern) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: pattern
            integer(c_int) :: status
        end function

        function dc_pattern_structure(pattern, row_offsets, row_offset_count, columns, column_count) &
                bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: pattern
            integer(c_int32_t), intent(inout), optional :: row_offsets(*), columns(*)
            integer(c_size_t), value :: row_offset_count, column_count
            integer(c_int) :: status
        end function

        function dc_pattern_fill(pattern, interface, law, values, entry_count, active_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: pattern, interface
            type(dc_law), intent(in) :: law
            real(c_double), intent(inout) :: values(*)
            integer(c_size_t), value :: entry_count
            integer(c_size_t), intent(out), optional :: active_count
            integer(c_int) :: status
        end function

        function dc_map_create(interface, row_offsets, row_offset_count, columns, entry_count, map) &
                bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: interface
            integer(c_int32_t), intent(in) :: row_offsets(*), columns(*)
            integer(c_size_t), value :: row_offset_count, entry_count
            type(c_ptr), intent(out) :: map
            integer(c_int) :: status
        end function

        function dc_map_create_64(interface, row_offsets, row_offset_count, columns, entry_count, map) &
                bind(c) result(status)
            import :: c_int, c_int64_t, c_ptr, c_size_t
            type(c_ptr), value :: interface
            integer(c_int64_t), intent(in) :: row_offsets(*), columns(*)
            integer(c_size_t), value :: row_offset_count, entry_count
            type(c_ptr), intent(out) :: map
            integer(c_int) :: status
        end function

        function dc_map_destroy(map) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: map
            integer(c_int) :: status
        end function

        function dc_map_add(map, interface, law, values, entry_count, active_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: map, interface
            type(dc_law), intent(in) :: law
            real(c_double), intent(inout) :: values(*)
            integer(c_size_t), value :: entry_count
            integer(c_size_t), intent(out), optional :: active_count
            integer(c_int) :: status
        end function

        function dc_operator_create(interface, law, tangent, active_count) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: interface
            type(dc_law), intent(in) :: law
            type(c_ptr), intent(out) :: tangent
            integer(c_size_t), intent(out), optional :: active_count
            integer(c_int) :: status
        end function

        function dc_operator_destroy(tangent) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: tangent
            integer(c_int) :: status
        end function

        function dc_operator_product(tangent, v, product, equation_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: tangent
            real(c_double), intent(in) :: v(*)
            real(c_double), intent(inout) :: product(*)
            integer(c_size_t), value :: equation_count
            integer(c_int) :: status
        end function

        function dc_operator_transposed_product(tangent, v, product, equation_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: tangent
            real(c_double), intent(in) :: v(*)
            real(c_double), intent(inout) :: product(*)
            integer(c_size_t), value :: equation_count
            integer(c_int) :: status
        end function

        function dc_operator_diagonal(tangent, diagonal, equation_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: tangent
            real(c_double), intent(inout) :: diagonal(*)
            integer(c_size_t), value :: equation_count
            integer(c_int) :: status
        end function

        function dc_pair(options, slave, candidates, candidate_count, outward, masters, capacity, pairing) &
                bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_size_t, dc_options, dc_pairing
            type(dc_options), intent(in), optional :: options
            real(c_double), intent(in) :: slave(*), candidates(*), outward(*)
            integer(c_size_t), value :: candidate_count, capacity
            integer(c_int32_t), intent(inout) :: masters(*)
            type(dc_pairing), intent(inout) :: pairing
            integer(c_int) :: status
        end function

        function dc_gap(element, slave, masters, master_count, mode, point, gradient, gradient_size, hessian, &
                hessian_size) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_size_t, dc_element, dc_point
            type(dc_element), intent(in) :: element
            real(c_double), intent(in) :: slave(*), masters(*)
            integer(c_size_t), value :: master_count, gradient_size, hessian_size
            integer(c_int32_t), value :: mode
            type(dc_point), intent(inout) :: point
            real(c_double), intent(inout), optional :: gradient(*), hessian(*)
            integer(c_int) :: status
        end function

        function dc_faces_create(positions, node_count, facets, facet_count, slave_facets, slave_facet_count, options, &
                degree, faces) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t, dc_options
            real(c_double), intent(in) :: positions(*)
            integer(c_size_t), value :: node_count, facet_count, slave_facet_count
            integer(c_int32_t), intent(in) :: facets(*)
            integer(c_int32_t), intent(in), optional :: slave_facets(*)
            type(dc_options), intent(in), optional :: options
            integer(c_int32_t), value :: degree
            type(c_ptr), intent(out) :: faces
            integer(c_int) :: status
        end function

        function dc_faces_create_self_contact(positions, node_count, facets, facet_count, options, degree, faces) &
                bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t, dc_options
            real(c_double), intent(in) :: positions(*)
            integer(c_size_t), value :: node_count, facet_count
            integer(c_int32_t), intent(in) :: facets(*)
            type(dc_options), intent(in), optional :: options
            integer(c_int32_t), value :: degree
            type(c_ptr), intent(out) :: faces
            integer(c_int) :: status
        end function

        function dc_faces_create_in_window(master, slave, positions, node_count, options, degree, faces) &
                bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t, dc_options
            type(c_ptr), value :: master, slave
            real(c_double), intent(in) :: positions(*)
            integer(c_size_t), value :: node_count
            type(dc_options), intent(in), optional :: options
            integer(c_int32_t), value :: degree
            type(c_ptr), intent(out) :: faces
            integer(c_int) :: status
        end function

        function dc_faces_destroy(faces) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: faces
            integer(c_int) :: status
        end function

        function dc_faces_counts(faces, node_count, slave_count) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: faces
            integer(c_size_t), intent(out), optional :: node_count, slave_count
            integer(c_int) :: status
        end function

        ! A node on a sharp edge of the slave is there once for each sheet.
        function dc_faces_slaves(faces, slaves, slave_count) bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: faces
            integer(c_int32_t), intent(inout) :: slaves(*)
            integer(c_size_t), value :: slave_count
            integer(c_int) :: status
        end function

        function dc_faces_set_symmetry(faces, planes, plane_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: faces
            real(c_double), intent(in), optional :: planes(*)
            integer(c_size_t), value :: plane_count
            integer(c_int) :: status
        end function

        function dc_faces_set_pressures(faces, pressures) bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr
            type(c_ptr), value :: faces
            integer(c_int32_t), value :: pressures
            integer(c_int) :: status
        end function

        function dc_flat_facets(quadratic, face_count, nodes_per_face, facets, facet_capacity) bind(c) result(status)
            import :: c_int, c_int32_t, c_size_t
            integer(c_int32_t), intent(in) :: quadratic(*)
            integer(c_size_t), value :: face_count, nodes_per_face, facet_capacity
            integer(c_int32_t), intent(inout) :: facets(*)
            integer(c_int) :: status
        end function

        function dc_faces_add_quadratic(faces, quadratic, face_count, nodes_per_face) bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: faces
            integer(c_int32_t), intent(in) :: quadratic(*)
            integer(c_size_t), value :: face_count, nodes_per_face
            integer(c_int) :: status
        end function

        function dc_faces_add_quadratic_by_number(faces, side, quadratic, face_count, nodes_per_face) bind(c) &
            result(status)
            import :: c_int, c_int32_t, c_int64_t, c_ptr, c_size_t
            type(c_ptr), value :: faces
            integer(c_int32_t), value :: side
            integer(c_int64_t), intent(in) :: quadratic(*)
            integer(c_size_t), value :: face_count, nodes_per_face
            integer(c_int) :: status
        end function

        function dc_faces_set_equations(faces, equations, node_count, equation_count) bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: faces
            integer(c_int32_t), intent(in), optional :: equations(*)
            integer(c_size_t), value :: node_count, equation_count
            integer(c_int) :: status
        end function

        function dc_faces_refresh(faces, positions, node_count, report) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t, dc_faces_report
            type(c_ptr), value :: faces
            real(c_double), intent(in) :: positions(*)
            integer(c_size_t), value :: node_count
            type(dc_faces_report), intent(inout), optional :: report
            integer(c_int) :: status
        end function

        function dc_faces_update(faces, positions, node_count, report) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t, dc_faces_report
            type(c_ptr), value :: faces
            real(c_double), intent(in) :: positions(*)
            integer(c_size_t), value :: node_count
            type(dc_faces_report), intent(inout), optional :: report
            integer(c_int) :: status
        end function

        function dc_faces_evaluate(faces, law, mode) bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr, dc_law
            type(c_ptr), value :: faces
            type(dc_law), intent(in) :: law
            integer(c_int32_t), value :: mode
            integer(c_int) :: status
        end function

        function dc_faces_contacts(faces, outcomes, gaps, pressures, areas, normals, slave_count) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: faces
            integer(c_int32_t), intent(inout), optional :: outcomes(*)
            real(c_double), intent(inout), optional :: gaps(*), pressures(*), areas(*), normals(*)
            integer(c_size_t), value :: slave_count
            integer(c_int) :: status
        end function

        !> Contact at the integration points over the master; without arrays point_count gets how many there are.
        function dc_faces_points(faces, faces_of_points, positions, areas, gaps, normals, pressures, tractions, capacity, &
                point_count) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: faces
            integer(c_int32_t), intent(inout), optional :: faces_of_points(*)
            real(c_double), intent(inout), optional :: positions(*), areas(*), gaps(*), normals(*), pressures(*), tractions(*)
            integer(c_size_t), value :: capacity
            integer(c_size_t), intent(out), optional :: point_count
            integer(c_int) :: status
        end function

        !> Friction of all slave nodes, of the last evaluation.
        function dc_faces_friction(faces, states, tractions, slips, slave_count) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: faces
            integer(c_int32_t), intent(inout), optional :: states(*)
            real(c_double), intent(inout), optional :: tractions(*), slips(*)
            integer(c_size_t), value :: slave_count
            integer(c_int) :: status
        end function

        !> With friction: the positions of the moment are the end of an increment.
        function dc_faces_accept(faces, law, stuck_count, sliding_count, unanchored_count, dropped_count, dissipated) &
                bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: faces
            type(dc_law), intent(in) :: law
            integer(c_size_t), intent(out), optional :: stuck_count, sliding_count, unanchored_count, dropped_count
            real(c_double), intent(out), optional :: dissipated
            integer(c_int) :: status
        end function

        !> A round of the augmented Lagrangian for friction, in equilibrium.
        function dc_faces_augment(faces, law, moves, slave_count) bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: faces
            type(dc_law), intent(in) :: law
            integer(c_int32_t), intent(in), optional :: moves(*)
            integer(c_size_t), value :: slave_count
            integer(c_int) :: status
        end function

        function dc_faces_slip_errors(faces, law, errors, slave_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t, dc_law
            type(c_ptr), value :: faces
            type(dc_law), intent(in) :: law
            real(c_double), intent(inout) :: errors(*)
            integer(c_size_t), value :: slave_count
            integer(c_int) :: status
        end function

        function dc_faces_roll_back(faces) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: faces
            integer(c_int) :: status
        end function

        !> Numbers for a restart; without history count gets how many there are.
        function dc_faces_history(faces, history, capacity, count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: faces
            real(c_double), intent(inout), optional :: history(*)
            integer(c_size_t), value :: capacity
            integer(c_size_t), intent(out) :: count
            integer(c_int) :: status
        end function

        function dc_faces_augmented_history(faces, history, capacity, count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: faces
            real(c_double), intent(inout), optional :: history(*)
            integer(c_size_t), value :: capacity
            integer(c_size_t), intent(out) :: count
            integer(c_int) :: status
        end function

        function dc_faces_set_history(faces, history, count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: faces
            real(c_double), intent(in), optional :: history(*)
            integer(c_size_t), value :: count
            integer(c_int) :: status
        end function

        function dc_faces_add_forces(faces, forces, equation_count, active_count, missed_count) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: faces
            real(c_double), intent(inout) :: forces(*)
            integer(c_size_t), value :: equation_count
            integer(c_size_t), intent(out), optional :: active_count, missed_count
            integer(c_int) :: status
        end function

        function dc_faces_product(faces, tangent, v, product, equation_count) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: faces
            integer(c_int32_t), value :: tangent
            real(c_double), intent(in) :: v(*)
            real(c_double), intent(inout) :: product(*)
            integer(c_size_t), value :: equation_count
            integer(c_int) :: status
        end function

        function dc_faces_triplets(faces, tangent, rows, columns, values, capacity, count) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: faces
            integer(c_int32_t), value :: tangent
            integer(c_int32_t), intent(inout), optional :: rows(*), columns(*)
            real(c_double), intent(inout), optional :: values(*)
            integer(c_size_t), value :: capacity
            integer(c_size_t), intent(out) :: count
            integer(c_int) :: status
        end function

        !> Which nodes couple: those of clique k, from 0, are nodes(offsets(k + 1) + 1:offsets(k + 2)), counted from 0.
        function dc_faces_cliques(faces, offsets, offset_capacity, nodes, node_capacity, clique_count, entry_count) &
                bind(c) result(status)
            import :: c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: faces
            integer(c_int32_t), intent(inout), optional :: offsets(*), nodes(*)
            integer(c_size_t), value :: offset_capacity, node_capacity
            integer(c_size_t), intent(out), optional :: clique_count, entry_count
            integer(c_int) :: status
        end function

        function dc_gap_batch(element, element_count, outwards, support_radii, slaves, masters, offsets, mode, points, &
                gradients, gradient_size, hessians, hessian_size) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_size_t, dc_element, dc_point
            type(dc_element), intent(in) :: element
            integer(c_size_t), value :: element_count, gradient_size, hessian_size
            real(c_double), intent(in), optional :: outwards(*), support_radii(*)
            real(c_double), intent(in) :: slaves(*), masters(*)
            integer(c_size_t), intent(in) :: offsets(*)
            integer(c_int32_t), value :: mode
            type(dc_point), intent(inout) :: points(*)
            real(c_double), intent(inout), optional :: gradients(*), hessians(*)
            integer(c_int) :: status
        end function

        function dc_element_system(law, gap, area, master_count, gradient, hessian, force, nodal_forces, nodal_forces_size, &
                tangent, tangent_size) bind(c) result(status)
            import :: c_double, c_int, c_size_t, dc_law
            type(dc_law), intent(in) :: law
            real(c_double), value :: gap, area
            integer(c_size_t), value :: master_count, nodal_forces_size, tangent_size
            real(c_double), intent(in) :: gradient(*)
            real(c_double), intent(in), optional :: hessian(*)
            real(c_double), intent(out), optional :: force
            real(c_double), intent(inout), optional :: nodal_forces(*), tangent(*)
            integer(c_int) :: status
        end function
    end interface

    interface
        !> strlen of C.
        pure function length_of(text) bind(c, name="strlen") result(length)
            import :: c_ptr, c_size_t
            type(c_ptr), value, intent(in) :: text
            integer(c_size_t) :: length
        end function
    end interface

contains

    !> The sentence to the last status that was not DC_OK, or another text of the library.
    function dc_text(text) result(string)
        type(c_ptr), intent(in), optional :: text
        character(len=:), allocatable :: string
        character(kind=c_char), pointer :: characters(:)
        type(c_ptr) :: start
        integer :: k, length

        start = dc_message()
        if (present(text)) start = text
        length = int(length_of(start))
        call c_f_pointer(start, characters, [length])
        allocate (character(len=length) :: string)
        do k = 1, length
            string(k:k) = characters(k)
        end do
    end function
end module diffuse_contact
