! Calls uel.f90 as Abaqus does, with facets and friction: slaves on springs are pressed on a curved surface and drawn across it.
!
!     gfortran -O2 uel.f90 drive_uel_domains.f90 $(pkg-config --libs diffuse_contact) -o drive_uel_domains && ./drive_uel_domains
!
! 1. Increments with Newton's method and cut-backs. Every force and stiffness of a window's element is compared with those of an
!    interface of the whole surface, which is kept over the analysis: bit for bit.
! 2. The same with all facets in JPROPS instead of a window; without friction; with a coefficient of 0, and without one.
! 3. AMATRX against central differences of RHS; perturbations; a slave that leaves its window; times of a call.
!
! Ends with stop code 1 if something is wrong. A library without kernels of friction is said to be one, and 1 to 3 are done without
! friction. With --refuse and the number of a wrong input it makes one call, which is to end in XIT, stop code 2.
program drive_uel_domains
    use, intrinsic :: iso_c_binding
    use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
    use diffuse_contact
    use diffuse_contact_domains, only: encoded_window, FRICTION_PROPERTIES
    implicit none

    integer, parameter :: side = 17, masters = side*side, total_nodes = masters + 1, facet_count = (side - 1)**2, elements = 3
    integer, parameter :: wanted = FRICTION_PROPERTIES
    real(8), parameter :: spring = 60, tolerance = 1d-10, reach = 1.1d0, skin = 0.2d0

    !> A user element, and an interface of the whole surface with its slave.
    type :: contact_element
        integer :: label = 0
        integer, allocatable :: nodes(:), jprops(:)
        real(8), allocatable :: coords(:, :), svars(:), history(:), rhs(:), amatrx(:, :)
        type(c_ptr) :: whole = c_null_ptr
    end type

    type(contact_element) :: contacts(elements)
    real(8) :: props(wanted) = [3d3, 0d0, 0d0, 0d0, 0d0, 0d0, 0d0, 0d0, 0d0, 0.3d0, 0d0, 0d0, 0.9d0]
    real(8) :: first(3, masters), moved(3, masters), slaves(3, elements), u(3, elements), accepted(3, elements), &
        before(3, masters), pnewdt, energy(8), total, dt
    integer(c_int32_t) :: facets(4, facet_count)
    integer :: cutbacks, iterations, told_properties = wanted, told_kind = 1, told_step = 0, e
    logical :: has_kernels
    character(len=16) :: argument

    open (7, file='/dev/stderr')
    call make_surface()
    has_kernels = is_friction_built_in()
    call get_command_argument(1, argument)
    do e = 1, elements
        call make_window(contacts(e), e)
    end do
    if (argument == '--refuse') call make_wrong_call()
    if (has_kernels) then
        call run_analysis('with friction')
        call check_coefficient_of_zero()
        call run_analysis('with friction')
    else
        print '(a)', 'friction is not built in'
        props(10) = 0
        call run_analysis('without friction')
    end if
    call check_tangents()
    call check_all_facets()
    call check_perturbation(contacts(2), size(contacts(2)%rhs))
    call check_left_window()
    call check_divergence()
    call measure()

contains

    subroutine fail(why)
        character(len=*), intent(in) :: why

        print '(2a)', 'failed: ', why
        stop 1
    end subroutine

    subroutine expect(status)
        integer(c_int), intent(in) :: status

        if (status /= DC_OK) call fail(dc_text())
    end subroutine

    !> A saddle, outside above, with cells that are not all alike; slaves just over it.
    subroutine make_surface()
        real(8), parameter :: at(2, elements) = reshape([6.3d0, 7.2d0, 8.6d0, 9.4d0, 9.1d0, 6.55d0], [2, elements])
        integer :: k

        do k = 0, masters - 1
            associate (x => mod(k, side) - 8 + 0.15d0*sin(3.1d0*k), y => k/side - 8 + 0.15d0*cos(1.7d0*k))
                first(:, k + 1) = [x + 8, y + 8, height(x, y)]
            end associate
        end do
        do k = 0, facet_count - 1
            facets(:, k + 1) = int(mod(k, side - 1) + side*(k/(side - 1)) + [0, 1, side + 1, side], c_int32_t)
        end do
        do e = 1, elements
            slaves(:, e) = [at(:, e), height(at(1, e) - 8, at(2, e) - 8) + 0.05d0]
        end do
    end subroutine

    pure real(8) function height(x, y)
        real(8), intent(in) :: x, y

        height = 0.02d0*x**2 - 0.03d0*y**2
    end function

    logical function is_friction_built_in()
        type(c_ptr) :: whole
        type(dc_law) :: law

        whole = whole_interface(slaves(:, 1))
        call expect(dc_refresh(whole, [first, slaves(:, 1)], int(total_nodes, c_size_t)))
        law%penalty = 1
        law%friction = 0.3d0
        is_friction_built_in = dc_accept(whole, law) == DC_OK
        call expect(dc_destroy(whole))
    end function

    type(c_ptr) function whole_interface(slave) result(whole)
        real(8), intent(in) :: slave(3)
        type(dc_options) :: options

        call expect(dc_options_default(options))
        options%distance_limit = props(13)
        call expect(dc_create([first, slave], int(total_nodes, c_size_t), facets, int(facet_count, c_size_t), &
            [int(masters, c_int32_t)], 1_c_size_t, slave_facet_count=0_c_size_t, options=options, interface=whole))
    end function

    !> The element with the window of a slave.
    subroutine make_window(element, e)
        type(contact_element), intent(out) :: element
        integer, intent(in) :: e
        type(c_ptr) :: window
        integer(c_size_t) :: nodes, integer_count, real_count
        integer(c_int64_t), allocatable :: names(:), integers(:)
        real(8), allocatable :: reals(:)

        element%label = e
        element%whole = whole_interface(slaves(:, e))
        call expect(dc_update(element%whole, [first, slaves(:, e)], int(total_nodes, c_size_t)))
        call expect(dc_window_create(element%whole, [slaves(:, e) - reach, slaves(:, e) + reach], 1_c_size_t, skin, window))
        call expect(dc_window_counts(window, nodes, integer_count=integer_count, real_count=real_count))
        allocate (names(nodes), integers(integer_count), reals(real_count))
        call expect(dc_window_names(window, names, nodes, facet_count=0_c_size_t))
        call expect(dc_window_numbers(window, integers, integer_count, reals, real_count))
        call expect(dc_window_destroy(window))
        if (nodes > 0.6d0*masters) call fail('a window is nearly all')
        element%jprops = encoded_window(integers, reals)
        ! One node more, that takes no part.
        element%nodes = [total_nodes, int(names) + 1, 1]
        if (any(names == 0)) call fail('the corner is in a window')
        print '(3(a, i0), a)', 'element ', e, ': a window of ', nodes, ' nodes, ', size(element%jprops), ' entries of JPROPS'
        call size_up(element, e)
    end subroutine

    subroutine size_up(element, e)
        type(contact_element), intent(inout) :: element
        integer, intent(in) :: e
        real(8) :: points(3, total_nodes)
        integer :: count

        points(:, :masters) = first
        points(:, total_nodes) = slaves(:, e)
        count = size(element%nodes)
        element%coords = points(:, element%nodes)
        allocate (element%rhs(3*count), element%amatrx(3*count, 3*count))
        allocate (element%svars(3*count + 11), element%history(3*count + 11))
        element%history = 0
    end subroutine

    !> The master at a time: up, and tilted about the y axis.
    subroutine move_master(time)
        real(8), intent(in) :: time
        real(8) :: angle
        integer :: k

        angle = 0.012d0*time
        do k = 1, masters
            associate (x => first(1, k) - 8, z => first(3, k))
                moved(:, k) = [8 + cos(angle)*x + sin(angle)*z, first(2, k), cos(angle)*z - sin(angle)*x + 0.05d0*time]
            end associate
        end do
    end subroutine

    !> Where the spring of a slave is drawn to: down, then along.
    pure function pull(time, e) result(offset)
        real(8), intent(in) :: time
        integer, intent(in) :: e
        real(8) :: offset(3), along

        along = max(0d0, time - 0.3d0)
        offset = [0.5d0*along*(e - 1.7d0), 0.35d0*along*sin(1d0*e), -0.6d0*min(1d0, time/0.3d0)]
    end function

    !> From the beginning to the end, with every call compared with the whole surface.
    subroutine run_analysis(name)
        character(len=*), intent(in) :: name
        integer :: attempts, increments, found, slid, stuck, changes
        type(dc_law) :: law
        real(8) :: work

        law = law_of()
        total = 0
        accepted = 0
        before = first
        moved = first
        work = 0
        do e = 1, elements
            contacts(e)%history = 0
            call begin_whole(contacts(e), e, law)
        end do
        dt = 0.5d0
        cutbacks = 0
        iterations = 0
        increments = 0
        slid = 0
        stuck = 0
        do attempts = 1, 60
            dt = min(dt, 1 - total)
            call solve_increment(law, found)
            if (found == 0) then
                cutbacks = cutbacks + 1
                dt = dt*min(pnewdt, 0.5d0)
                cycle
            end if
            iterations = iterations + found
            increments = increments + 1
            total = total + dt
            accepted = u
            before = moved
            changes = 0
            do e = 1, elements
                if (props(10) > 0) call expect(dc_accept(contacts(e)%whole, law))
                call check_state(contacts(e), slid, stuck)
                contacts(e)%history = contacts(e)%svars
            end do
            dt = min(1.5d0*dt, 0.12d0)
            if (total > 1 - 1d-12) exit
        end do
        if (total < 1 - 1d-12) call fail('too many attempts')
        print '(2a, 3(i0, a))', name, ': ', increments, ' increments, ', cutbacks, ' cut-backs, ', iterations, ' iterations'
        if (cutbacks == 0) call fail('nothing was cut back')
        if (.not. all_touch()) call fail('a slave is not in contact')
        if (props(10) > 0 .and. (slid == 0 .or. stuck == 0)) call fail('slaves stick and slide')
        if (props(10) > 0) print '(i0, a, i0, a)', stuck, ' ends of increments stick, ', slid, ' slide'
    end subroutine

    logical function all_touch()
        integer :: k

        all_touch = .true.
        do k = 1, elements
            all_touch = all_touch .and. contacts(k)%history(10) > 0
        end do
    end function

    type(dc_law) function law_of() result(law)
        law%penalty = props(1)
        law%friction = props(10)
        law%tangential_stiffness = props(11)
        law%shear_limit = props(12)
        law%tangent = int(props(7), c_int32_t)
    end function

    subroutine begin_whole(element, e, law)
        type(contact_element), intent(in) :: element
        integer, intent(in) :: e
        type(dc_law), intent(in) :: law

        call expect(dc_set_history(element%whole, count=0_c_size_t))
        call expect(dc_refresh(element%whole, [first, slaves(:, e)], int(total_nodes, c_size_t)))
        if (law%friction > 0) call expect(dc_accept(element%whole, law))
    end subroutine

    !> Newton's method from the accepted state. found: number of iterations, 0 if it is to be cut back.
    subroutine solve_increment(law, found)
        type(dc_law), intent(in) :: law
        integer, intent(out) :: found
        real(8) :: residual(3, elements), tangent(3, 3)
        integer :: k, i

        u = accepted
        call move_master(total + dt)
        pnewdt = 1
        found = 0
        do i = 1, 15
            do e = 1, elements
                call call_uel(contacts(e), e)
                ! It knows more than a window.
                if (pnewdt < 1 .and. all(abs(contacts(e)%amatrx) <= 0)) return
                call compare_with_whole(contacts(e), e, law)
                residual(:, e) = contacts(e)%rhs(1:3) + spring*(pull(total + dt, e) - u(:, e))
            end do
            if (pnewdt < 1) return
            if (all(abs(residual) < tolerance)) then
                found = i
                return
            end if
            do e = 1, elements
                tangent = contacts(e)%amatrx(1:3, 1:3)
                do k = 1, 3
                    tangent(k, k) = tangent(k, k) + spring
                end do
                u(:, e) = u(:, e) + solution(tangent, residual(:, e))
            end do
        end do
        pnewdt = 0.25d0
    end subroutine

    !> Of three equations, by Cramer's rule.
    pure function solution(a, b) result(x)
        real(8), intent(in) :: a(3, 3), b(3)
        real(8) :: x(3), other(3, 3)
        integer :: k

        do k = 1, 3
            other = a
            other(:, k) = b
            x(k) = determinant(other)/determinant(a)
        end do
    end function

    pure real(8) function determinant(a)
        real(8), intent(in) :: a(3, 3)

        determinant = dot_product(a(:, 1), cshift(a(:, 2), 1)*cshift(a(:, 3), -1) - cshift(a(:, 2), -1)*cshift(a(:, 3), 1))
    end function

    !> A call in the present increment.
    subroutine call_uel(element, e)
        type(contact_element), intent(inout) :: element
        integer, intent(in) :: e
        real(8) :: forces(size(element%rhs), 1)

        element%svars = element%history
        call call_at(element, displacements(element, e, moved, u), displacements(element, e, moved, u) - &
            displacements(element, e, before, accepted), forces)
        element%rhs = forces(:, 1)
    end subroutine

    !> Displacements of the element's nodes.
    function displacements(element, e, master, slave) result(found)
        type(contact_element), intent(in) :: element
        integer, intent(in) :: e
        real(8), intent(in) :: master(:, :), slave(:, :)
        real(8) :: found(size(element%rhs)), points(3, total_nodes)

        points(:, :masters) = master
        points(:, total_nodes) = slaves(:, e) + slave(:, e)
        found = reshape(points(:, element%nodes) - element%coords, [size(found)])
    end function

    !> A call as Abaqus makes it.
    subroutine call_at(element, at, increment, forces)
        type(contact_element), intent(inout) :: element
        real(8), intent(in) :: at(:), increment(:)
        real(8), intent(out) :: forces(:, :)
        real(8) :: none(size(at)), predefined(2, 1, size(element%nodes)), no_loads(1, 1), moves(size(at), 1)
        integer :: no_types(1, 1)

        none = 0
        predefined = 0
        no_loads = 0
        no_types = 0
        forces = huge(1d0)
        element%amatrx = huge(1d0)
        moves(:, 1) = increment
        call uel(forces, element%amatrx, element%svars, energy, size(at), 1, size(element%svars), props, told_properties, &
            element%coords, 3, size(element%nodes), at, moves, none, none, 1, [total, total], dt, 1, 1, element%label, [0d0], 0, &
            no_types, no_loads, predefined, 1, [1, 1, told_kind, told_step, 0], size(at), no_loads, 1, pnewdt, element%jprops, &
            size(element%jprops), 1d0)
    end subroutine

    !> Forces and stiffness are those of the whole surface, to the last bit.
    subroutine compare_with_whole(element, e, law)
        type(contact_element), intent(in) :: element
        integer, intent(in) :: e
        type(dc_law), intent(in) :: law
        real(8) :: forces(3*total_nodes)
        integer :: place(3*total_nodes), k
        integer(c_int32_t), allocatable :: rows(:), columns(:)
        real(8), allocatable :: values(:), matrix(:, :)
        integer(c_size_t) :: count

        ! As the element: each call begins at the start of the increment.
        call expect(dc_refresh(element%whole, known(element, e, before, accepted), int(total_nodes, c_size_t)))
        call expect(dc_follow(element%whole, known(element, e, moved, u), int(total_nodes, c_size_t)))
        call expect(dc_evaluate(element%whole, int(DC_HESSIAN, c_int32_t)))
        forces = 0
        call expect(dc_add_forces(element%whole, law, forces, int(3*total_nodes, c_size_t)))
        place = 0
        do k = 1, size(element%nodes)
            place(3*element%nodes(k) - 2:3*element%nodes(k)) = [3*k - 2, 3*k - 1, 3*k]
        end do
        do k = 1, size(forces)
            if (place(k) == 0) then
                if (abs(forces(k)) > 0) call fail('a force beyond the window')
            else if (element%rhs(place(k)) /= forces(k)) then
                call fail('a force is another one than that of the whole surface')
            end if
        end do
        allocate (rows(40000), columns(40000), values(40000), matrix(size(element%rhs), size(element%rhs)))
        call expect(dc_triplets(element%whole, law, int(DC_FULL, c_int32_t), rows, columns, values, 40000_c_size_t, count))
        matrix = 0
        do k = 1, int(count)
            if (place(rows(k) + 1) == 0 .or. place(columns(k) + 1) == 0) then
                if (abs(values(k)) > 0) call fail('a stiffness beyond the window')
                cycle
            end if
            matrix(place(rows(k) + 1), place(columns(k) + 1)) = values(k)
        end do
        if (any(matrix /= element%amatrx)) call fail('the stiffness is another one than that of the whole surface')
    end subroutine

    !> All nodes, those of the element at COORDS + U.
    function known(element, e, master, slave) result(points)
        type(contact_element), intent(in) :: element
        integer, intent(in) :: e
        real(8), intent(in) :: master(:, :), slave(:, :)
        real(8) :: points(3, total_nodes)

        points(:, :masters) = master
        points(:, element%nodes) = element%coords + reshape(displacements(element, e, master, slave), [3, size(element%nodes)])
    end function

    !> Coulomb's law, and what SVARS say of it.
    subroutine check_state(element, slid, stuck)
        type(contact_element), intent(in) :: element
        integer, intent(inout) :: slid, stuck
        ! The force on the slave is the traction but for the curvature of the surface over the elastic slip.
        real(8), parameter :: curved = 0.02d0
        real(8) :: limit

        if (element%svars(1) /= 3 .or. element%svars(11) /= 0) call fail('there is a result')
        if (props(10) <= 0) then
            if (any(abs(element%svars([2, 4, 5, 6, 7, 8])) > 0)) call fail('without friction there is no history')
            return
        end if
        limit = props(10)*element%svars(10)
        if (props(12) > 0) limit = min(limit, props(12))
        if (.not. norm2(element%svars(5:7)) <= limit*(1 + curved)) call fail('traction above the limit')
        select case (nint(element%svars(4)))
        case (DC_SLIP)
            slid = slid + 1
            if (norm2(element%svars(5:7)) < limit*(1 - curved)) call fail('a slave slides below the limit')
            if (.not. element%svars(8) > element%history(8)) call fail('a slave slides without work')
        case (DC_STICK)
            stuck = stuck + 1
            if (abs(element%svars(8) - element%history(8)) > 0) call fail('a slave that sticks does no work')
        case default
            if (element%svars(10) > 0) call fail('a slave with force is open')
        end select
        if (abs(element%svars(2) - nint(element%svars(2))) > 0 .or. element%svars(2) < 5) call fail('there is no anchor')
    end subroutine

    !> A coefficient of 0, PROPERTIES=9 and 12: the same bits, and the state of before is that of an analysis without friction.
    subroutine check_coefficient_of_zero()
        real(8) :: rhs(size(contacts(1)%rhs)), amatrx(size(rhs), size(rhs)), told

        told = props(10)
        props(10) = 0
        call run_analysis('without friction')
        call call_uel(contacts(1), 1)
        rhs = contacts(1)%rhs
        amatrx = contacts(1)%amatrx
        if (any(amatrx /= transpose(amatrx))) call fail('without friction the stiffness is symmetric')
        props(11) = 7
        call call_uel(contacts(1), 1)
        if (any(contacts(1)%rhs /= rhs) .or. any(contacts(1)%amatrx /= amatrx)) call fail('a coefficient of 0 is no friction')
        told_properties = 9
        ! Without PROPS(13) a slave looks farther than its window in vain.
        props(11) = 0
        call call_uel(contacts(1), 1)
        if (any(contacts(1)%rhs /= rhs) .or. any(contacts(1)%amatrx /= amatrx)) call fail('PROPERTIES=9 are without friction')
        told_properties = wanted
        props(10) = told
        print '(a)', 'a coefficient of zero is no friction'
    end subroutine

    !> AMATRX of all elements, where some stick and some slide.
    subroutine check_tangents()
        real(8) :: worst, asymmetry

        asymmetry = 0
        worst = 0
        do e = 1, elements
            u = accepted
            ! The first two are pushed on, the last one by less than it takes to slide.
            if (e < 3) u(:, e) = u(:, e) + 0.02d0*[0.5d0*(e - 1.7d0), 0.35d0*sin(1d0*e), 0d0]
            if (e == 3) u(:, e) = u(:, e) + 1d-5
            call check_tangent(contacts(e), e, size(contacts(e)%rhs), worst, asymmetry)
        end do
        u = accepted
        print '(2(a, es8.1))', 'tangents against central differences: ', worst, ', asymmetry ', asymmetry
        if (.not. worst < 1d-7) call fail('the tangent is not the derivative of the force')
        if (has_kernels .neqv. asymmetry > 1d-3) call fail('slip makes the tangent unsymmetric')
    end subroutine

    !> AMATRX against central differences of RHS; what else a call fills.
    subroutine check_tangent(element, e, freedoms, worst, asymmetry)
        type(contact_element), intent(inout) :: element
        integer, intent(in) :: e, freedoms
        real(8), intent(inout) :: worst, asymmetry
        real(8), parameter :: step = 1d-6
        real(8) :: whole(freedoms, freedoms), at(freedoms), start(freedoms), shifted(freedoms), rhs(freedoms), &
            forces(freedoms, 1, 2), slope(freedoms), largest
        integer :: k

        call call_uel(element, e)
        whole = element%amatrx
        rhs = element%rhs
        largest = maxval(abs(whole))
        asymmetry = max(asymmetry, maxval(abs(whole - transpose(whole)))/largest)
        at = displacements(element, e, moved, u)
        start = displacements(element, e, before, accepted)
        told_kind = 5
        do k = 1, freedoms
            shifted = at
            shifted(k) = at(k) + step
            element%svars = element%history
            call call_at(element, shifted, shifted - start, forces(:, :, 1))
            shifted(k) = at(k) - step
            call call_at(element, shifted, shifted - start, forces(:, :, 2))
            slope = -(forces(:, 1, 1) - forces(:, 1, 2))/(2*step)
            ! A maximum leaves out what is no number.
            if (.not. all(abs(slope - whole(:, k)) <= huge(1d0))) call fail('a force or a tangent is no number')
            worst = max(worst, maxval(abs(slope - whole(:, k)))/largest)
            if (any(abs(element%amatrx) > 0)) call fail('LFLAGS(3) = 5 is the force alone')
        end do
        told_kind = 2
        call call_uel(element, e)
        if (any(element%amatrx /= whole) .or. any(abs(element%rhs) > 0)) call fail('LFLAGS(3) = 2 is the stiffness alone')
        if (any(element%svars /= element%history)) call fail('LFLAGS(3) = 2 leaves the history as it is')
        told_kind = 1
        props(7) = 1
        call call_uel(element, e)
        props(7) = 0
        if (any(element%rhs /= rhs)) call fail('PROPS(7) is no matter of the force')
        if (all(element%amatrx == whole)) call fail('PROPS(7) = 1 is another tangent')
    end subroutine

    !> All facets in JPROPS: the same numbers as with a window.
    subroutine check_all_facets()
        type(contact_element) :: element
        integer :: k, at

        do e = 1, elements
            call call_uel(contacts(e), e)
            element = with_all_facets(contacts(e)%history, e)
            call call_uel(element, e)
            if (any(element%svars(:size(contacts(e)%svars)) /= contacts(e)%svars)) call fail('SVARS are those with a window')
            do k = 1, size(contacts(e)%nodes)
                at = findloc(element%nodes, contacts(e)%nodes(k), 1)
                if (any(element%rhs(3*at - 2:3*at) /= contacts(e)%rhs(3*k - 2:3*k))) call fail('all facets are a window')
            end do
        end do
        print '(a)', 'all facets give what a window gives'
    end subroutine

    type(contact_element) function with_all_facets(history, e) result(element)
        real(8), intent(in) :: history(:)
        integer, intent(in) :: e
        integer :: k

        element%label = e
        element%nodes = [total_nodes, (k, k=1, masters)]
        element%jprops = [facet_count, reshape(facets, [4*facet_count]) + 2]
        call size_up(element, e)
        element%history(:size(history)) = history
    end function

    !> A perturbation is -K DU, about the base state.
    subroutine check_perturbation(element, freedoms)
        type(contact_element), intent(inout) :: element
        integer, intent(in) :: freedoms
        real(8) :: whole(freedoms, freedoms), forces(freedoms, 1), changes(freedoms), at(freedoms)
        integer :: k

        call call_uel(element, 2)
        whole = element%amatrx
        at = displacements(element, 2, moved, u)
        changes = [(1d-3*sin(1.7d0*k), k=1, freedoms)]
        told_step = 1
        told_kind = 100
        element%svars = element%history
        call call_at(element, at, changes, forces)
        told_step = 0
        told_kind = 1
        if (any(element%svars /= element%history)) call fail('a perturbation leaves the base state as it is')
        if (.not. all(abs(forces(:, 1) + matmul(whole, changes)) < 1d-13*maxval(abs(whole)))) &
            call fail('the force of a perturbation is -K DU')
        print '(a)', 'perturbations are linear'
    end subroutine

    !> A slave beyond its window: a smaller increment, and nothing of it is kept.
    subroutine check_left_window()
        u = accepted
        u(1, 1) = u(1, 1) + 4
        pnewdt = 5
        call call_uel(contacts(1), 1)
        if (pnewdt /= 0.25d0) call fail('a slave beyond its window asks for a cut-back')
        if (any(abs(contacts(1)%rhs) > 0) .or. any(abs(contacts(1)%amatrx) > 0)) call fail('beyond the window there is no force')
        if (any(contacts(1)%svars /= contacts(1)%history)) call fail('SVARS stay beyond the window')
        ! In the window, beyond the limit of the distance: no contact, which is a result.
        u = accepted
        u(3, 1) = u(3, 1) + 0.9d0
        props(13) = 0.1d0
        pnewdt = 5
        call call_uel(contacts(1), 1)
        props(13) = 0.9d0
        if (contacts(1)%svars(11) /= DC_TOO_FAR .or. any(abs(contacts(1)%rhs) > 0)) call fail('a slave far away has no contact')
        if (contacts(1)%history(9) >= 0) call fail('the slave penetrated')
        if (pnewdt /= 5) call fail('a slave that leaves the master asks for no cut-back')
        print '(a)', 'a slave beyond its window asks for a cut-back'
        u = accepted
        pnewdt = 1
    end subroutine

    !> An iteration that diverges, in the first increment and in a later one: positions that are no numbers, a force that is none.
    subroutine check_divergence()
        real(8) :: penalty, kept(size(contacts(1)%history))
        integer :: k

        penalty = props(1)
        kept = contacts(1)%history
        do k = 1, 3
            u = accepted
            if (k < 3) u(1, 1) = ieee_value(1d0, ieee_quiet_nan)
            if (k == 2) contacts(1)%history = 0
            if (k == 3) props(1) = huge(1d0)
            pnewdt = 5
            call call_uel(contacts(1), 1)
            if (pnewdt /= 0.25d0) call fail('a divergent iteration asks for a cut-back')
            if (any(abs(contacts(1)%rhs) > 0) .or. any(abs(contacts(1)%amatrx) > 0)) &
                call fail('without numbers there is no force')
            if (any(contacts(1)%svars /= contacts(1)%history)) call fail('SVARS stay without numbers')
            contacts(1)%history = kept
            props(1) = penalty
        end do
        print '(a)', 'a divergent iteration asks for a cut-back'
        u = accepted
        pnewdt = 1
    end subroutine

    !> Processor time, of all threads.
    subroutine measure()
        integer, parameter :: calls = 100
        type(contact_element) :: element
        real(8) :: from, to
        integer :: k

        call cpu_time(from)
        do k = 1, calls
            call call_uel(contacts(2), 2)
        end do
        call cpu_time(to)
        print '(a, f0.2, a)', 'a call with a window takes ', 1d3*(to - from)/calls, ' ms'
        element = with_all_facets(contacts(2)%history, 2)
        call cpu_time(from)
        do k = 1, calls/20
            call call_uel(element, 2)
        end do
        call cpu_time(to)
        print '(a, i0, a, f0.1, a)', 'one with all ', facet_count, ' facets ', 1d3*(to - from)/(calls/20), ' ms'
    end subroutine

    !> One call with a mistake in it.
    subroutine make_wrong_call()
        type(contact_element) :: element
        integer :: mistake

        call get_command_argument(2, argument)
        read (argument, *) mistake
        u = 0
        accepted = 0
        before = first
        moved = first
        total = 0
        dt = 1
        pnewdt = 1
        element = contacts(1)
        if (.not. has_kernels .and. mistake /= 16) props(10) = 0
        if (mistake > 7 .and. mistake < 12 .and. has_kernels) then
            call call_uel(element, 1)
            element%history = element%svars
        end if
        select case (mistake)
        case (1)
            element%svars = element%svars(:11)
            element%history = element%history(:11)
        case (2)
            props(10) = 0.3d0
            element%svars = element%svars(:3*size(element%nodes) + 10)
            element%history = element%history(:3*size(element%nodes) + 10)
        case (3:5)
            element = with_all_facets([0d0], 1)
            if (mistake == 3) element%jprops(6) = 1
            if (mistake == 4) element%jprops(7) = size(element%nodes) + 1
            if (mistake == 5) element%jprops = element%jprops(:size(element%jprops) - 1)
        case (6)
            props(9) = 0.1d0
        case (7)
            props(10) = ieee_value(1d0, ieee_quiet_nan)
        case (8)
            element%history(1) = 1
        case (9)
            element%history(1) = 3
            element%history(2) = ieee_value(1d0, ieee_quiet_nan)
        case (10)
            element%history(1) = 3
            element%history(2) = 5
            element%history(13:17) = [1d0, 0d0, 1d6, -1d0, 1d0]
            if (.not. has_kernels) props(10) = 0.3d0
        case (11)
            element%jprops(4) = 5
        case (12)
            element%coords(:, [4, 5]) = element%coords(:, [5, 4])
            element%nodes([4, 5]) = element%nodes([5, 4])
        case (13)
            told_kind = 5
            u(1, 1) = 5
        case (14)
            props(3) = 2
        case (15)
            element%jprops = [0]
            props(6) = 1
            props(10) = 0.3d0
        case (16)
            props(10) = 0.3d0
            ! Fails without kernels alone.
        case (17)
            element%jprops = element%jprops(:size(element%jprops) - 1)
        end select
        call call_uel(element, 1)
        call fail('the mistake was accepted')
    end subroutine
end program drive_uel_domains

!> What Abaqus has to end an analysis.
subroutine xit
    stop 2
end subroutine xit
