!> The part of the user element of uel.f90 that has facets: masters by domains of influence, and friction.
!!
!! Each call makes the library's interface of its one slave, from COORDS, JPROPS and SVARS alone, and destroys it. So nothing is kept
!! between calls: several threads may call at once, and a restart or a cut-back has all it needs in SVARS.
module diffuse_contact_domains
    use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_int, c_int32_t, c_int64_t, c_null_ptr, c_ptr, c_size_t
    use diffuse_contact
    implicit none
    private
    public :: contact_call, run_contact_call, find_unmet_demand, encoded_window, FRICTION_PROPERTIES, FACETS_STATE

    !> SVARS(1) of an element with facets, once it was called.
    integer, parameter :: FACETS_STATE = 3
    !> SVARS before the history of friction.
    integer, parameter :: BEFORE_HISTORY = 12
    !> PROPERTIES with friction.
    integer, parameter :: FRICTION_PROPERTIES = 13
    !> In place of an integer of a window that needs more than JPROPS have; three pieces follow.
    integer, parameter :: LARGE = -2, LARGEST = 999999999

    character(len=*), parameter :: LEFT = &
        'its slave, or its master, has left what its window holds: write a window with wider boxes, or a larger skin'

    !> A call of UEL: what was asked, and by which element.
    type :: contact_call
        integer :: label = 0
        logical :: ends_increment = .false., is_perturbation = .false., wants_force = .false., wants_stiffness = .false.
    end type

contains

    !> What an element with facets needs that it has not; nothing if all is well.
    subroutine find_unmet_demand(nnode, svars, nsvars, props, nprops, jprops, njprop, demand)
        integer, intent(in) :: nnode, nsvars, nprops, njprop, jprops(njprop)
        real(8), intent(in) :: svars(nsvars), props(nprops)
        character(len=*), intent(out) :: demand
        real(8) :: told(FRICTION_PROPERTIES)

        demand = ''
        told = all_properties(props)
        if (.not. abs(told(9)) <= 0) then
            demand = 'PROPS(9) of 0: with facets there is no such regularity'
        else if (.not. (all(told(10:13) >= 0) .and. all(told(10:13) <= huge(1d0)))) then
            demand = 'PROPS(10:13), where there are such, that are finite and not negative'
        else if (nsvars < BEFORE_HISTORY) then
            demand = 'VARIABLES of at least 12 with facets'
        else if (told(10) > 0 .and. nsvars < BEFORE_HISTORY + 2 + 3*(nnode - 1)) then
            demand = 'VARIABLES of at least 3 times the number of nodes and 11 with friction'
        else if (.not. are_facets()) then
            demand = 'JPROPS of facets whose corners are nodes 2 to NNODE, or of a window, and I PROPERTIES for all of them'
        else if (.not. is_own_history()) then
            demand = 'SVARS that it has written itself, or zeros'
        end if

    contains

        logical function are_facets()
            integer :: corners(4), k

            are_facets = .false.
            if (jprops(1) < 0) then
                if (jprops(1) /= -1 .or. njprop < 3) return
                if (any(jprops(2:3) < 1) .or. any(jprops(2:3) > njprop)) return
                are_facets = jprops(2) <= njprop - 3 .and. jprops(3) <= (njprop - 3)/3
                return
            end if
            if (jprops(1) > (njprop - 1)/4) return
            do k = 1, jprops(1)
                corners = jprops(4*k - 2:4*k + 1)
                if (any(corners(1:3) < 2) .or. any(corners > nnode) .or. corners(4) < 0 .or. corners(4) == 1) return
            end do
            are_facets = .true.
        end function

        !> The numbers of the history itself are checked by the library.
        logical function is_own_history()
            is_own_history = any(svars(1) == [0d0, real(FACETS_STATE, 8)])
            if (.not. is_own_history .or. svars(1) == 0) return
            is_own_history = svars(2) >= 0 .and. svars(2) <= nsvars - BEFORE_HISTORY
            if (is_own_history) is_own_history = svars(2) == nint(svars(2)) .and. all(abs(svars(8:9)) <= huge(1d0))
            ! Another coefficient than none goes on from a history, and none needs none.
            if (is_own_history .and. told(10) > 0) is_own_history = svars(2) > 0
        end function
    end subroutine

    !> PROPS, with zeros for those that are not given.
    pure function all_properties(props) result(told)
        real(8), intent(in) :: props(:)
        real(8) :: told(FRICTION_PROPERTIES)
        integer :: given

        told = 0
        given = min(size(props), FRICTION_PROPERTIES)
        told(:given) = props(:given)
    end function

    !> One call. now and start: positions of all nodes, at the moment and at the start of the increment.
    subroutine run_contact_call(this, coords, now, start, du, props, jprops, svars, rhs, amatrx, energy, pnewdt)
        type(contact_call), intent(in) :: this
        real(8), intent(in) :: coords(:, :), now(:, :), start(:, :), du(:, :), props(:)
        integer, intent(in) :: jprops(:)
        real(8), intent(inout) :: svars(:), rhs(:, :), amatrx(:, :), energy(:), pnewdt
        real(8) :: told(FRICTION_PROPERTIES), area, was, normal_force, given(size(svars))
        real(8), allocatable :: friction(:), residual(:)
        type(c_ptr) :: interface, window
        type(dc_law) :: law, frictionless
        type(dc_contact_data) :: contact
        integer, allocatable :: order(:)
        logical :: has_friction, is_lost

        is_lost = .false.
        given = svars
        told = all_properties(props)
        area = merge(told(2), 1d0, told(2) > 0)
        was = merge(svars(9), 0d0, svars(1) > 0)
        has_friction = told(10) > 0
        window = c_null_ptr
        call make_law()
        call make_interface()
        if (has_friction) call take_history()
        if (.not. is_lost) call find_contact()
        if (.not. is_lost) call take_results()
        if (.not. is_lost .and. this%ends_increment) call write_state()
        if (is_lost) call ask_for_less()
        call expect(dc_destroy(interface))

    contains

        !> Per area of the slave, which has all forces of it.
        subroutine make_law()
            law%penalty = told(1)*area
            law%tangent = int(told(7), c_int32_t)
            frictionless = law
            law%friction = told(10)
            law%tangential_stiffness = told(11)*area
            law%shear_limit = told(12)*area
        end subroutine

        subroutine make_interface()
            type(dc_options) :: options
            integer(c_int32_t) :: slaves(1)
            integer(c_int32_t), allocatable :: facets(:, :), equations(:, :)
            integer :: nodes, k

            call expect(dc_options_default(options))
            options%weight = int(told(3), c_int32_t)
            if (told(8) > 0) options%cutback_penetration = told(8)
            options%distance_limit = told(13)
            if (jprops(1) < 0) call make_window()
            nodes = size(coords, 2)
            if (c_associated(window)) nodes = window_nodes() + 1
            if (nodes > size(coords, 2)) call stop_with('its window has more nodes than the element')
            ! The master's nodes come first, as a window wants it.
            order = [(k, k=2, nodes), 1]
            slaves = int(nodes - 1, c_int32_t)
            if (c_associated(window)) then
                call check_first_positions(nodes - 1)
                call expect(dc_create_in_window(window, in_order(coords), count_of(order), slaves, 1_c_size_t, &
                    slave_facet_count=0_c_size_t, options=options, interface=interface))
                call expect(dc_window_destroy(window))
            else
                ! Nodes from 0, without the slave; -1 for the fourth of a triangle.
                facets = reshape(int(jprops(2:1 + 4*jprops(1)), c_int32_t), [4, jprops(1)])
                facets = merge(facets - 2, -1_c_int32_t, facets > 0)
                call expect(dc_create(in_order(coords), count_of(order), facets, int(jprops(1), c_size_t), slaves, 1_c_size_t, &
                    slave_facet_count=0_c_size_t, options=options, interface=interface))
            end if
            allocate (equations(3, nodes))
            do k = 1, nodes
                equations(:, k) = int(3*order(k) - [3, 2, 1], c_int32_t)
            end do
            call expect(dc_set_equations(interface, equations, count_of(order), int(size(coords), c_size_t)))
        end subroutine

        subroutine make_window()
            integer(c_int64_t), allocatable :: integers(:)
            real(c_double), allocatable :: reals(:)

            call decode(jprops, integers, reals)
            if (size(integers) == 0) call stop_with('JPROPS are no window')
            call expect(dc_window_from_numbers(integers, int(size(integers), c_size_t), reals, int(size(reals), c_size_t), window))
        end subroutine

        integer function window_nodes()
            integer(c_size_t) :: count

            call expect(dc_window_counts(window, node_count=count))
            window_nodes = int(count)
        end function

        !> The nodes of the window are nodes 2 and following.
        subroutine check_first_positions(nodes)
            integer, intent(in) :: nodes
            real(c_double) :: first(3, nodes), span
            integer :: k

            call expect(dc_window_first_positions(window, first, int(nodes, c_size_t)))
            ! An input file may have fewer digits than what the window was made of.
            span = maxval(maxval(coords(:, 2:), 2) - minval(coords(:, 2:), 2))
            do k = 1, nodes
                if (.not. maxval(abs(first(:, k) - coords(:, k + 1))) <= 1d-8*span) &
                    call stop_with('its nodes are not those of its window, in the order of that')
            end do
        end subroutine

        subroutine find_contact()
            ! A slave that has come nearer to the back of a thin master stays on the side where the increment began.
            call attempt(dc_refresh(interface, in_order(start), count_of(order)))
            if (.not. is_lost) call attempt(dc_follow(interface, in_order(now), count_of(order)))
            if (is_lost) return
            call expect(dc_evaluate(interface, int(DC_HESSIAN, c_int32_t)))
            call look_at_contact()
            if (contact%outcome == DC_BEYOND_WINDOW) call lose(LEFT)
        end subroutine

        subroutine look_at_contact()
            integer(c_int) :: status

            status = dc_contact_of(interface, 0_c_size_t, contact)
            if (status /= DC_NO_CONTACT) call expect(status)
        end subroutine

        !> The history at the start of the increment.
        subroutine take_history()
            integer :: count

            if (svars(1) > 0) then
                count = int(svars(2))
                call expect(dc_set_history(interface, svars(BEFORE_HISTORY + 1:BEFORE_HISTORY + count), int(count, c_size_t)))
                return
            end if
            call attempt(dc_refresh(interface, in_order(start), count_of(order)))
            if (is_lost) return
            call expect(dc_evaluate(interface, int(DC_VALUE, c_int32_t)))
            call look_at_contact()
            if (contact%outcome == DC_BEYOND_WINDOW) call stop_with(LEFT)
            call attempt(dc_accept(interface, law))
        end subroutine

        !> Forces and stiffness.
        subroutine take_results()
            real(8), allocatable :: tangent(:, :)
            real(8) :: one(1), factor
            integer :: k

            allocate (residual(size(coords)), friction(size(coords)))
            residual = 0
            friction = 0
            call attempt(dc_add_forces(interface, law, residual, count_of(residual)))
            if (is_lost) return
            if (has_friction) then
                call attempt(dc_add_forces(interface, frictionless, friction, count_of(residual)))
                if (is_lost) return
                friction = residual - friction
            end if
            call attempt(dc_forces(interface, frictionless, forces=one, slave_count=1_c_size_t))
            if (is_lost) return
            normal_force = one(1)
            if (this%wants_stiffness .or. this%is_perturbation) then
                allocate (tangent(size(residual), size(residual)))
                call assemble(tangent)
                if (is_lost) return
                if (this%wants_stiffness) amatrx = tangent
            end if
            if (this%is_perturbation) then
                if (this%wants_force) then
                    do k = 1, size(rhs, 2)
                        rhs(:, k) = -matmul(tangent, du(:, k))
                    end do
                end if
                energy(2) = -dot_product(residual, du(:, 1)) + 0.5d0*dot_product(du(:, 1), matmul(tangent, du(:, 1)))
                return
            end if
            if (this%wants_force) rhs(:, 1) = residual
            if (.not. this%ends_increment) return
            call expect(dc_cutback(interface, factor))
            ! The interface of this call does not know that the slave penetrated before.
            if (was < 0) then
                select case (contact%outcome)
                case (DC_CONTACT, DC_TOO_FAR, DC_NO_CANDIDATE, DC_BEYOND_BORDER, DC_NOTHING_OVER)
                case (DC_FOOT_OUTSIDE)
                    factor = min(factor, 0.5d0)
                case default
                    factor = min(factor, 0.25d0)
                end select
            end if
            if (factor < 1) pnewdt = min(pnewdt, factor)
        end subroutine

        subroutine assemble(tangent)
            real(8), intent(out) :: tangent(:, :)
            integer(c_int32_t), allocatable :: rows(:), columns(:)
            real(c_double), allocatable :: values(:)
            integer(c_size_t) :: found
            integer :: k

            allocate (rows(size(tangent)), columns(size(tangent)), values(size(tangent)))
            tangent = 0
            call attempt(dc_triplets(interface, law, int(DC_FULL, c_int32_t), rows, columns, values, &
                count_of(values), found))
            if (is_lost) return
            do k = 1, int(found)
                associate (here => tangent(rows(k) + 1, columns(k) + 1))
                    here = here + values(k)
                end associate
            end do
        end subroutine

        !> SVARS and ENERGY at the end of the increment, if it ends here.
        subroutine write_state()
            integer(c_size_t) :: stuck, sliding, count
            real(8) :: work, along

            svars(2:7) = 0
            if (svars(1) == 0) svars(8) = 0
            svars(1) = FACETS_STATE
            svars(3) = contact%support_radius
            svars(9) = merge(contact%gap, 0d0, contact%outcome == DC_CONTACT)
            svars(10) = normal_force
            svars(11) = contact%outcome
            svars(12) = contact%fallback
            energy(2) = 0.5d0*normal_force*max(0d0, -svars(9))
            if (.not. has_friction) return
            call attempt(dc_accept(interface, law, stuck, sliding, dissipated=work))
            if (is_lost) return
            svars(4) = DC_OPEN
            if (stuck > 0) svars(4) = DC_STICK
            if (sliding > 0) svars(4) = DC_SLIP
            svars(5:7) = friction(1:3)
            svars(8) = svars(8) + work
            ! What the tangential penalty stores.
            along = norm2(friction(1:3))
            energy(2) = energy(2) + 0.5d0*along**2/merge(law%tangential_stiffness, law%penalty, law%tangential_stiffness > 0)
            energy(4) = svars(8)
            call expect(dc_history(interface, capacity=0_c_size_t, count=count))
            if (count > size(svars) - BEFORE_HISTORY) then
                call stop_with('its history of friction needs more VARIABLES')
            end if
            call expect(dc_history(interface, svars(BEFORE_HISTORY + 1:), int(size(svars) - BEFORE_HISTORY, c_size_t), count))
            svars(2) = real(count, 8)
        end subroutine

        !> There is no result. In an iteration a smaller increment may help.
        subroutine lose(why)
            character(len=*), intent(in) :: why

            if (.not. this%ends_increment) call stop_with(why)
            write (7, '(a, i0, 2a)') 'diffuse contact: element ', this%label, ': ', why
            is_lost = .true.
        end subroutine

        !> An iteration that diverges has positions or forces that are no numbers.
        subroutine attempt(status)
            integer(c_int), intent(in) :: status

            if (status == DC_NOT_FINITE .or. status == DC_OVERFLOW) then
                call lose(dc_text())
            else
                call expect(status)
            end if
        end subroutine

        !> A smaller increment, which begins where this one did.
        subroutine ask_for_less()
            svars = given
            rhs = 0
            amatrx = 0
            energy = 0
            pnewdt = min(pnewdt, 0.25d0)
        end subroutine

        !> Positions in the order of the interface.
        function in_order(positions) result(ordered)
            real(8), intent(in) :: positions(:, :)
            real(8) :: ordered(3*size(order))

            ordered = reshape(positions(:, order), [3*size(order)])
        end function

        subroutine expect(status)
            integer(c_int), intent(in) :: status

            if (status /= DC_OK) call stop_with(dc_text())
        end subroutine

        !> Ends the analysis with a sentence in the message file.
        subroutine stop_with(why)
            character(len=*), intent(in) :: why

            write (7, '(a, i0, 2a)') 'diffuse contact: element ', this%label, ': ', why
            call xit
        end subroutine
    end subroutine

    pure integer(c_size_t) function count_of(array)
        class(*), intent(in) :: array(:)

        count_of = size(array, kind=c_size_t)
    end function

    ! Windows in JPROPS: -1, the number of entries of the integers, that of the reals, and the entries. An input file has no room for
    ! all digits of a number, so that reals stand there as their bits, in three pieces.

    !> JPROPS of a window.
    function encoded_window(integers, reals) result(jprops)
        integer(c_int64_t), intent(in) :: integers(:)
        real(c_double), intent(in) :: reals(:)
        integer, allocatable :: jprops(:)
        integer :: places, k, next

        places = 0
        do k = 1, size(integers)
            places = places + merge(1, 4, is_small(integers(k)))
        end do
        allocate (jprops(3 + places + 3*size(reals)))
        jprops(1:3) = [-1, places, size(reals)]
        next = 4
        do k = 1, size(integers)
            if (is_small(integers(k))) then
                jprops(next) = int(integers(k))
                next = next + 1
            else
                jprops(next) = LARGE
                jprops(next + 1:next + 3) = pieces(integers(k))
                next = next + 4
            end if
        end do
        do k = 1, size(reals)
            jprops(next:next + 2) = pieces(transfer(reals(k), 0_c_int64_t))
            next = next + 3
        end do
    end function

    elemental logical function is_small(number)
        integer(c_int64_t), intent(in) :: number

        is_small = number >= -1 .and. number <= LARGEST
    end function

    pure function pieces(bits)
        integer(c_int64_t), intent(in) :: bits
        integer :: pieces(3)

        pieces = int([ibits(bits, 0, 22), ibits(bits, 22, 21), ibits(bits, 43, 21)])
    end function

    pure integer(c_int64_t) function whole(parts)
        integer, intent(in) :: parts(3)

        whole = ior(int(parts(1), c_int64_t), ior(ishft(int(parts(2), c_int64_t), 22), ishft(int(parts(3), c_int64_t), 43)))
    end function

    !> The numbers of a window; no integers if JPROPS are none.
    subroutine decode(jprops, integers, reals)
        integer, intent(in) :: jprops(:)
        integer(c_int64_t), allocatable, intent(out) :: integers(:)
        real(c_double), allocatable, intent(out) :: reals(:)
        integer :: next, count, k, last

        last = 3 + jprops(2)
        allocate (integers(jprops(2)), reals(jprops(3)))
        count = 0
        next = 4
        do while (next <= last)
            count = count + 1
            if (jprops(next) /= LARGE) then
                integers(count) = jprops(next)
                next = next + 1
            else
                if (next + 3 > last) exit
                integers(count) = whole(jprops(next + 1:next + 3))
                next = next + 4
            end if
        end do
        if (next /= last + 1 .or. last + 3*size(reals) > size(jprops)) count = 0
        integers = integers(:count)
        if (count == 0) return
        do k = 1, size(reals)
            reals(k) = transfer(whole(jprops(last + 3*k - 2:last + 3*k)), 0d0)
        end do
    end subroutine
end module diffuse_contact_domains
