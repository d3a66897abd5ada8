! Calls uel.f90 as Abaqus does: a curved rigid surface is pressed against four nodes on springs, and tilted.
!
!     gfortran -O2 uel.f90 drive_uel.f90 $(pkg-config --libs diffuse_contact) -o drive_uel && ./drive_uel
!
! 1. Increments with Newton's method. SVARS are handed over as at the start of the increment, kept when it is accepted, and forgotten
!    when it is cut back; the whole motion is tried at once first, which is too much, so that PNEWDT has to act.
! 2. The tangent of each element is compared with central differences of its forces.
! 3. LFLAGS(3) is honoured, in general and in perturbation steps; the module's structures are those of the library.
! 4. Every property, a slave that loses its surface, and one with too few candidates for the quadratic basis.
!
! Ends with stop code 1 if something is wrong. With the argument --bits it prints all numbers of the last call of each increment and
! element in hexadecimal; with --bits and a number, which is PROPS(9), it does 1 and 2 alone. With --refuse and the number of a wrong
! input it makes one call, which is to end in XIT, stop code 2.
program drive_uel
    use, intrinsic :: iso_fortran_env, only: int64
    implicit none

    integer, parameter :: side = 7, candidates = side*side, nodes = candidates + 1, freedoms = 3*nodes, elements = 4
    integer, parameter :: variables = nodes + 11, unknowns = 3*elements, properties = 9
    real(8), parameter :: spring = 50, travel = 0.9d0, tilt = 0.12d0, tolerance = 1d-10
    ! The last one would be refused. It is not to be looked at: there are PROPERTIES=8, unless said otherwise.
    integer, parameter :: needed = 8
    real(8) :: props(properties) = [3d3, 0d0, 0d0, 0d0, 0d0, 1d0, 0d0, 0.1d0, -1d0]

    real(8) :: coords(3, nodes, elements), u(freedoms, elements), &
        accepted(freedoms, elements), rhs(freedoms, elements), amatrx(freedoms, freedoms, elements), &
        history(variables, elements), svars(variables, elements), energy(8), pnewdt, total, dt, worst
    real(8) :: stiffness(unknowns, unknowns), residual(unknowns)
    integer :: increment, attempts, iteration, cutbacks, iterations, e
    ! What a call says that is the same in all but the wrong ones.
    integer :: told_mcrd = 3, told_properties = needed, told_variables = -1, procedure_type = 1
    logical :: prints_bits
    character(len=16) :: argument

    call get_command_argument(1, argument)
    prints_bits = argument == '--bits'
    open (7, file='/dev/stderr')
    call make_mesh()
    if (command_argument_count() == 2 .and. prints_bits) then
        call get_command_argument(2, argument)
        read (argument, *) props(9)
        told_properties = 9
    end if
    if (argument == '--refuse') call make_wrong_call()

    history = 0
    accepted = 0
    total = 0
    dt = 1
    cutbacks = 0
    iterations = 0
    increment = 1
    attempts = 0
    do while (total < 1)
        attempts = attempts + 1
        if (attempts > 40) call fail('too many attempts')
        dt = min(dt, 1 - total)
        call solve_increment(is_converged=iteration)
        if (iteration == 0) then
            cutbacks = cutbacks + 1
            dt = dt*min(pnewdt, 0.5d0)
            cycle
        end if
        iterations = iterations + iteration
        if (prints_bits) call print_bits()
        accepted = u
        history = svars
        total = total + dt
        print '(a, i0, a, f0.6, a, i0, a, 4es14.6)', 'increment ', increment, ' to ', total, ': ', iteration, &
            ' iterations, forces', svars(10, :)
        increment = increment + 1
    end do
    print '(a, i0, a, i0, a)', 'accepted with ', cutbacks, ' cut-backs and ', iterations, ' iterations'
    if (cutbacks == 0) call fail('nothing was cut back')
    if (.not. all(svars(10, :) > 0)) call fail('a slave is not in contact')

    call check_tangent()
    if (told_properties == 9) stop
    call check_flags()
    call check_properties()
    call check_lost_surface()
    call check_divergence()
    call check_few_candidates()
    call check_structures()
    call check_adaptive_tangent()

contains

    subroutine fail(why)
        character(len=*), intent(in) :: why

        print '(2a)', 'failed: ', why
        stop 1
    end subroutine

    !> Candidates on a paraboloid, outside above; the slaves just over it.
    subroutine make_mesh()
        real(8), parameter :: at(2, elements) = reshape([2.3d0, 2.2d0, 3.7d0, 2.4d0, 2.6d0, 3.8d0, 3.9d0, 3.6d0], [2, 4])
        integer :: k

        do e = 1, elements
            coords(:, 1, e) = [at(1, e), at(2, e), 0.02d0]
            do k = 0, candidates - 1
                coords(1:2, k + 2, e) = [real(mod(k, side), 8), real(k/side, 8)]
                associate (x => coords(1, k + 2, e) - 3, y => coords(2, k + 2, e) - 3)
                    coords(3, k + 2, e) = -0.04d0*x**2 - 0.03d0*y**2
                end associate
            end do
        end do
    end subroutine

    !> Displacements of the candidates at a time: up, and tilted about the y axis.
    subroutine move_candidates(time)
        real(8), intent(in) :: time
        real(8) :: angle, x, z
        integer :: k

        angle = tilt*time
        do e = 1, elements
            do k = 2, nodes
                x = coords(1, k, e) - 3
                z = coords(3, k, e)
                u(3*k - 2, e) = cos(angle)*x + sin(angle)*z - x
                u(3*k - 1, e) = 0
                u(3*k, e) = cos(angle)*z - sin(angle)*x - z + travel*time
            end do
        end do
    end subroutine

    !> One call of an increment.
    subroutine call_uel(e, kind, displacements, variables_in, force, tangent, variables_out)
        integer, intent(in) :: e, kind
        real(8), intent(in) :: displacements(freedoms), variables_in(variables)
        real(8), intent(out) :: force(freedoms), tangent(freedoms, freedoms), variables_out(variables)
        real(8) :: forces(freedoms, 1)

        variables_out = variables_in
        call call_any(e, kind, 0, coords(:, :, e), displacements, reshape(displacements - accepted(:, e), [freedoms, 1]), &
            props, variables_out, forces, tangent)
        force = forces(:, 1)
    end subroutine

    !> One call as Abaqus makes it. kind is LFLAGS(3), step LFLAGS(4); there are as many right-hand sides as increments.
    subroutine call_any(e, kind, step, points, displacements, increments, told, state, forces, tangent)
        integer, intent(in) :: e, kind, step
        real(8), intent(in) :: points(:, :), displacements(:), increments(:, :), told(:)
        real(8), intent(inout) :: state(:)
        real(8), intent(out) :: forces(:, :), tangent(:, :)
        real(8) :: none(size(displacements)), predefined(2, 1, size(points, 2)), no_loads(1, 1)
        integer :: flags(5), no_types(1, 1), own_variables

        none = 0
        predefined = 0
        no_loads = 0
        no_types = 0
        flags = [procedure_type, 1, kind, step, 0]
        forces = huge(1d0)
        tangent = huge(1d0)
        own_variables = merge(size(state), told_variables, told_variables < 0)
        call uel(forces, tangent, state, energy, size(displacements), size(increments, 2), own_variables, told, told_properties, &
            points, told_mcrd, size(points, 2), displacements, increments, none, none, 1, [total, total], dt, 1, increment, e, &
            [0d0], 0, no_types, no_loads, predefined, 1, flags, size(displacements), no_loads, 1, pnewdt, [0], 0, 1d0)
    end subroutine

    !> Newton's method from the accepted state. is_converged: number of iterations, 0 if it is to be cut back.
    subroutine solve_increment(is_converged)
        integer, intent(out) :: is_converged
        integer :: iterations_done, k

        u = accepted
        call move_candidates(total + dt)
        pnewdt = 1
        is_converged = 0
        do iterations_done = 1, 12
            do e = 1, elements
                call call_uel(e, 1, u(:, e), history(:, e), rhs(:, e), amatrx(:, :, e), svars(:, e))
            end do
            if (pnewdt < 1) return
            ! Only the slaves move freely, each on springs of its own.
            stiffness = 0
            do e = 1, elements
                residual(3*e - 2:3*e) = rhs(1:3, e) - spring*u(1:3, e)
                stiffness(3*e - 2:3*e, 3*e - 2:3*e) = amatrx(1:3, 1:3, e)
                do k = 3*e - 2, 3*e
                    stiffness(k, k) = stiffness(k, k) + spring
                end do
            end do
            if (all(abs(residual) < tolerance)) then
                is_converged = iterations_done
                return
            end if
            call solve()
            do e = 1, elements
                u(1:3, e) = u(1:3, e) + residual(3*e - 2:3*e)
            end do
        end do
        pnewdt = 0.25d0
    end subroutine

    !> Elimination with pivoting; the solution in residual.
    subroutine solve()
        integer :: column, row, pivot
        real(8) :: held(unknowns), factor

        do column = 1, unknowns
            pivot = column - 1 + maxloc(abs(stiffness(column:, column)), 1)
            held = stiffness(column, :)
            stiffness(column, :) = stiffness(pivot, :)
            stiffness(pivot, :) = held
            residual([column, pivot]) = residual([pivot, column])
            do row = column + 1, unknowns
                factor = stiffness(row, column)/stiffness(column, column)
                stiffness(row, :) = stiffness(row, :) - factor*stiffness(column, :)
                residual(row) = residual(row) - factor*residual(column)
            end do
        end do
        do row = unknowns, 1, -1
            residual(row) = (residual(row) - dot_product(stiffness(row, row + 1:), residual(row + 1:)))/stiffness(row, row)
        end do
    end subroutine

    !> AMATRX against central differences of RHS, all degrees of freedom of each element.
    subroutine check_tangent()
        real(8), parameter :: step = 1d-5
        real(8) :: moved(freedoms), forces(freedoms, 2), unused(freedoms, freedoms), state(variables), tangent(freedoms, freedoms)
        real(8) :: before(freedoms)
        integer :: k

        worst = 0
        do e = 1, elements
            call call_uel(e, 1, u(:, e), history(:, e), before, tangent, state)
            if (any(abs(tangent - transpose(tangent)) > 0)) call fail('the tangent is not symmetric')
            do k = 1, freedoms
                moved = u(:, e)
                moved(k) = u(k, e) + step
                call call_uel(e, 5, moved, history(:, e), forces(:, 1), unused, state)
                moved(k) = u(k, e) - step
                call call_uel(e, 5, moved, history(:, e), forces(:, 2), unused, state)
                moved = -(forces(:, 1) - forces(:, 2))/(2*step)
                ! A maximum leaves out what is no number.
                if (.not. all(abs(moved - tangent(:, k)) <= huge(1d0))) call fail('a force or a tangent is no number')
                worst = max(worst, maxval(abs(moved - tangent(:, k)))/maxval(abs(tangent)))
            end do
        end do
        print '(a, es8.1)', 'tangent against central differences: ', worst
        if (.not. worst < 1d-8) call fail('the tangent is not the derivative of the force')
    end subroutine

    !> What each kind of call fills.
    subroutine check_flags()
        real(8) :: force(freedoms), tangent(freedoms, freedoms), both(freedoms), whole(freedoms, freedoms), state(variables)
        integer :: k

        call call_uel(1, 1, u(:, 1), history(:, 1), both, whole, state)
        call call_uel(1, 2, u(:, 1), history(:, 1), force, tangent, state)
        if (any(force /= 0) .or. any(tangent /= whole)) call fail('LFLAGS(3) = 2 is the stiffness alone')
        if (any(state /= history(:, 1))) call fail('LFLAGS(3) = 2 leaves the history as it is')
        call call_uel(1, 5, u(:, 1), history(:, 1), force, tangent, state)
        if (any(force /= both) .or. any(tangent /= 0)) call fail('LFLAGS(3) = 5 is the force alone')
        do k = 3, 4
            call call_uel(1, k, u(:, 1), history(:, 1), force, tangent, state)
            if (any(force /= 0) .or. any(tangent /= 0)) call fail('LFLAGS(3) = 3 and 4 are damping and mass, which are zero')
            if (any(state /= history(:, 1))) call fail('LFLAGS(3) = 3 and 4 leave the history as it is')
        end do
        call check_perturbations(both, whole)
        print '(a)', 'flags are honoured'
    end subroutine

    !> Perturbations about the accepted state, two at a time: -K DU, and nothing else changes.
    subroutine check_perturbations(residual_there, whole)
        real(8), intent(in) :: residual_there(freedoms), whole(freedoms, freedoms)
        real(8) :: changes(freedoms, 2), forces(freedoms, 2), expected(freedoms, 2), tangent(freedoms, freedoms), &
            state(variables), limit
        integer, parameter :: kinds(4) = [100, 1, 5, 2]
        integer :: j, k

        do k = 1, freedoms
            changes(k, :) = 1d-3*[sin(1.7d0*k), cos(2.3d0*k)]
        end do
        expected = -matmul(whole, changes)
        limit = 1d-13*maxval(abs(whole))*1d-3*freedoms
        do j = 1, size(kinds)
            state = history(:, 1)
            pnewdt = 5
            call call_any(1, kinds(j), 1, coords(:, :, 1), u(:, 1), changes, props, state, forces, tangent)
            if (any(state /= history(:, 1)) .or. pnewdt /= 5) call fail('a perturbation leaves the base state as it is')
            if (kinds(j) == 2) then
                if (any(forces /= 0)) call fail('LFLAGS(3) = 2 of a perturbation is the stiffness alone')
            else
                if (.not. all(abs(forces - expected) < limit)) call fail('the force of a perturbation is -K DU')
            end if
            if (kinds(j) == 1 .or. kinds(j) == 2) then
                if (any(tangent /= whole)) call fail('the stiffness of a perturbation is that of the base state')
            else
                if (any(tangent /= 0)) call fail('LFLAGS(3) = 100 and 5 are the force alone')
            end if
        end do
        ! The change of the energy, to second order; the first order is the force itself.
        call call_any(1, 100, 1, coords(:, :, 1), u(:, 1), changes, props, state, forces, tangent)
        if (.not. abs(energy(2) + dot_product(residual_there + 0.5d0*expected(:, 1), changes(:, 1))) <= 1d-12*maxval(abs(whole))) &
            call fail('the energy of a perturbation')
        ! Two right-hand sides in a general step: the second one is the increment of the load.
        state = history(:, 1)
        call call_any(1, 1, 0, coords(:, :, 1), u(:, 1), changes*0, props, state, forces, tangent)
        if (any(forces(:, 2) /= 0) .or. all(forces(:, 1) == 0)) call fail('contact is no load')
    end subroutine

    !> Forces and tangent with other properties, in the accepted state.
    subroutine check_properties()
        real(8) :: told(properties), forces(freedoms, 1), tangent(freedoms, freedoms), other(freedoms, 1), &
            unused(freedoms, freedoms), state(variables), none(freedoms, 1), gaps(0:2)
        integer :: weight

        none = 0
        state = history(:, 1)
        call call_any(1, 1, 0, coords(:, :, 1), u(:, 1), none, props, state, forces, tangent)
        ! PROPS(2), an area: twice the penalty, to the last bit.
        told = props
        told(2) = 2
        state = history(:, 1)
        call call_any(1, 1, 0, coords(:, :, 1), u(:, 1), none, told, state, other, unused)
        if (any(other /= 2*forces) .or. any(unused /= 2*tangent)) call fail('PROPS(2) is the area')
        ! PROPS(7): e N N^T alone, f N = R.
        told = props
        told(7) = 1
        state = history(:, 1)
        call call_any(1, 1, 0, coords(:, :, 1), u(:, 1), none, told, state, other, unused)
        if (any(other /= forces)) call fail('PROPS(7) is no matter of the force')
        other = forces/state(10)
        if (.not. all(abs(unused - props(1)*matmul(other, transpose(other))) < 1d-12*props(1))) &
            call fail('PROPS(7) = 1 is Gauss-Newton')
        if (maxval(abs(unused - tangent)) < 1d-6*props(1)) call fail('PROPS(7) = 0 is the exact tangent')
        ! PROPS(3), the weights: three surfaces, each with its own tangent.
        do weight = 0, 2
            told = props
            told(3) = weight
            state = history(:, 1)
            call call_any(1, 1, 0, coords(:, :, 1), u(:, 1), none, told, state, forces, tangent)
            gaps(weight) = state(9)
            call check_slope(coords(:, :, 1), u(:, 1), history(:, 1), told, tangent)
        end do
        if (any(abs(gaps - cshift(gaps, 1)) < 1d-6)) call fail('PROPS(3) chooses the weight')
        call check_regularity()
        print '(a)', 'properties are honoured'
    end subroutine

    !> PROPS(9): 0 is the library's default. On an irregular mesh some single layers carry a fit that is regular enough for the default;
    !> more is asked of it, and a second layer is taken.
    subroutine check_regularity()
        real(8), parameter :: values(3) = [-1d0, 0d0, 0.1d0]
        real(8) :: told(properties), forces(freedoms, 1), tangent(freedoms, freedoms, 3), state(variables, 3), none(freedoms, 1), &
            points(3, nodes)
        integer :: before, k, place, more

        before = told_properties
        none = 0
        told = props
        points = coords(:, :, 1)
        do k = 2, nodes
            points(1:2, k) = points(1:2, k) + 0.3d0*[sin(37d0*k), cos(53d0*k)]
        end do
        more = 0
        do place = 0, 24
            points(:, 1) = [2.5d0 + 0.25d0*mod(place, 5), 2.5d0 + 0.05d0*place, -0.3d0]
            ! Without history, so that it is paired.
            state = 0
            do k = 1, 3
                told_properties = merge(needed, 9, k == 1)
                told(9) = values(k)
                call call_any(1, 1, 0, points, none(:, 1), none, told, state(:, k), forces, tangent(:, :, k))
            end do
            if (any(state(:, 2) /= state(:, 1)) .or. any(tangent(:, :, 2) /= tangent(:, :, 1))) &
                call fail('PROPS(9) = 0 is the default of the library')
            if (state(2, 3) <= state(2, 1)) cycle
            more = more + 1
            call check_slope(points, none(:, 1), state(:, 3), told, tangent(:, :, 3))
        end do
        if (more == 0) call fail('PROPS(9) takes more masters')
        told_properties = before
    end subroutine

    !> A tangent against the slope of the forces in one direction.
    subroutine check_slope(points, displacements, variables_in, told, tangent)
        real(8), intent(in) :: points(:, :), displacements(:), variables_in(:), told(:), tangent(:, :)
        real(8), parameter :: step = 1d-5
        real(8) :: direction(size(displacements)), forces(size(displacements), 1, 2), unused(size(tangent, 1), size(tangent, 2)), &
            state(size(variables_in)), none(size(displacements), 1), slope(size(displacements))
        integer :: k

        none = 0
        direction = [(sin(1.3d0*k), k=1, size(direction))]
        do k = 1, 2
            state = variables_in
            call call_any(1, 5, 0, points, displacements + merge(step, -step, k == 1)*direction, none, told, state, &
                forces(:, :, k), unused)
        end do
        slope = -(forces(:, 1, 1) - forces(:, 1, 2))/(2*step)
        if (all(slope == 0)) call fail('there is no force')
        if (.not. all(abs(matmul(tangent, direction) - slope) < 1d-7*maxval(abs(tangent)))) &
            call fail('the tangent is not the slope of the force')
    end subroutine

    !> A slave that has penetrated and has lost its surface asks for a smaller increment; one that had not, does not.
    subroutine check_lost_surface()
        real(8) :: moved(freedoms), forces(freedoms, 1), tangent(freedoms, freedoms), state(variables), none(freedoms, 1), &
            told(properties)
        integer :: k

        none = 0
        do k = 1, 2
            state = history(:, 1)
            if (k == 2) state(9) = 0.1d0
            moved = u(:, 1)
            moved(1) = moved(1) + 40
            pnewdt = 5
            call call_any(1, 1, 0, coords(:, :, 1), moved, none, props, state, forces, tangent)
            if (any(forces /= 0) .or. any(tangent /= 0)) call fail('without a result there is no force')
            if (state(1) /= 2 .or. state(9) /= 0 .or. state(10) /= 0 .or. state(11) == 0) call fail('the slave is not paired')
            if (k == 1 .and. all(pnewdt /= [0.25d0, 0.5d0])) call fail('a lost surface asks for a cut-back')
            if (k == 2 .and. pnewdt /= 5) call fail('a slave that has not penetrated asks for nothing')
        end do
        ! Back again.
        call call_any(1, 1, 0, coords(:, :, 1), u(:, 1), none, props, state, forces, tangent)
        if (state(1) /= 1 .or. all(forces == 0)) call fail('it is paired again')
        ! Never paired, so that SVARS hold PROPS(4:6), of any length.
        told = props
        told(6) = 5
        state = 0
        do k = 1, 2
            call call_any(1, 1, 0, coords(:, :, 1), moved, none, told, state, forces, tangent)
            if (state(1) /= 2 .or. any(forces /= 0)) call fail('a slave far away is not paired')
        end do
        print '(a)', 'a lost surface asks for a cut-back'
    end subroutine

    !> An iteration that diverges, of a slave with a pairing and of one without: positions that are no numbers, a force that is none.
    subroutine check_divergence()
        use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
        real(8) :: moved(freedoms), forces(freedoms, 1), tangent(freedoms, freedoms), state(variables), none(freedoms, 1), &
            told(properties)
        integer :: k

        none = 0
        do k = 1, 3
            state = history(:, 1)
            if (k == 2) state = 0
            moved = u(:, 1)
            told = props
            if (k < 3) moved(1) = ieee_value(1d0, ieee_quiet_nan)
            if (k == 3) told(1:2) = [huge(1d0), 1d10]
            none(1, 1) = moved(1) - moved(1)
            pnewdt = 5
            call call_any(1, 1, 0, coords(:, :, 1), moved, none, told, state, forces, tangent)
            if (any(forces /= 0) .or. any(tangent /= 0)) call fail('without numbers there is no force')
            if (k == 2 .and. any(state /= 0)) call fail('SVARS stay those of the beginning')
            if (k /= 2 .and. any(state /= history(:, 1))) call fail('SVARS stay those of the start of the increment')
            if (pnewdt /= 0.25d0) call fail('a divergent iteration asks for a cut-back')
        end do
        pnewdt = 1
        print '(a)', 'a divergent iteration asks for a cut-back'
    end subroutine

    !> Five candidates carry the linear basis alone.
    subroutine check_few_candidates()
        integer, parameter :: few = 6, own = 3*few
        real(8) :: points(3, few), forces(own, 1), tangent(own, own), state(few + 11), still(own), none(own, 1), before(few + 11)

        points = reshape([0.1d0, 0.2d0, -0.1d0, -1d0, -1d0, 0d0, 1d0, -1d0, 0.05d0, 1d0, 1d0, 0d0, -1d0, 1d0, 0.05d0, &
            0d0, 0d0, 0.02d0], [3, few])
        still = 0
        none = 0
        state = 0
        call call_any(9, 1, 0, points, still, none, props, state, forces, tangent)
        if (state(1) /= 1 .or. state(4) /= 1 .or. state(12) /= 2) call fail('five candidates carry the linear basis')
        before = state
        call call_any(9, 1, 0, points, still, none, props, state, forces, tangent)
        if (any(state /= before)) call fail('a pairing that is sound is kept')
        call check_slope(points, still, before, props, tangent)
        print '(a)', 'few candidates carry the linear basis'
    end subroutine

    !> One call with a mistake in it.
    subroutine make_wrong_call()
        use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
        real(8) :: told(properties), forces(freedoms, 1), tangent(freedoms, freedoms), state(variables), none(freedoms, 1), &
            still(freedoms), points(3, nodes), nan
        integer :: mistake, kind, count

        call get_command_argument(2, argument)
        read (argument, *) mistake
        nan = ieee_value(nan, ieee_quiet_nan)
        told = props
        none = 0
        still = 0
        state = 0
        accepted = 0
        total = 0
        dt = 1
        increment = 1
        pnewdt = 1
        kind = 1
        count = nodes
        points = coords(:, :, 1)
        if (mistake > 8) then
            ! The history of a sound call.
            call call_any(1, 1, 0, coords(:, :, 1), still, none, told, state, forces, tangent)
            if (state(1) /= 1 .or. state(2) < 6) call fail('the slave is not paired')
        end if
        select case (mistake)
        case (1)
            count = 3
        case (2)
            told_mcrd = 2
        case (3)
            told_properties = 7
        case (4)
            told_variables = variables - 1
        case (5)
            told(1) = 0
        case (6)
            told(3) = 3
        case (7)
            procedure_type = 11
        case (8)
            kind = 6
        case (9)
            state(1) = 3
        case (10)
            state(2) = 1d9
        case (11)
            state(2) = nan
        case (12)
            state(13) = 0
        case (13)
            state(14) = state(13)
        case (14)
            state(12 + int(state(2))) = nodes
        case (15)
            state(3) = nan
        case (16)
            state(4) = 3
        case (17)
            state(8) = 0.5d0
        case (18)
            state(5:7) = nan
        case (19)
            ! Where force and stiffness are asked for it is a smaller increment that is.
            kind = 5
            still(1) = nan
        case (20)
            told(4:6) = 0
        case (21)
            told(4) = nan
        case (22)
            ! In the plane of all candidates.
            state = 0
            points(3, 2:) = 0
            told(4:6) = [1, 1, 0]
        case (23)
            told_properties = 9
            told(9) = 1
        case (24)
            told_properties = 9
            told(9) = nan
        end select
        call call_any(1, kind, 0, points(:, 1:count), still(1:3*count), none(1:3*count, :), told, state, &
            forces(1:3*count, :), tangent(1:3*count, 1:3*count))
        call fail('the mistake was accepted')
    end subroutine

    !> The structures of the module are those of the library.
    subroutine check_structures()
        use, intrinsic :: iso_c_binding, only: c_sizeof
        use diffuse_contact
        type(dc_options) :: options
        type(dc_report) :: report
        type(dc_law) :: law
        type(dc_element) :: element
        type(dc_pairing) :: pairing

        if (dc_options_default(options) /= DC_OK) call fail(dc_text())
        if (options%radius_factor /= 1.25d0 .or. options%cutback_penetration /= 0.25d0) call fail('dc_options is another one')
        if (any([c_sizeof(options), c_sizeof(report), c_sizeof(law), c_sizeof(element), c_sizeof(pairing)] /= &
            [options%size, report%size, law%size, element%size, pairing%size])) call fail('a structure has another size')
        print '(a)', 'structures fit'
    end subroutine

    !> The tangent changes where the residual is 0.3 of the forces.
    subroutine check_adaptive_tangent()
        use diffuse_contact
        real(8), parameter :: ratio = 0.3d0

        if (dc_adaptive_tangent(ratio, 1d0) /= DC_EXACT) call fail('0.3 of the forces is near equilibrium')
        if (dc_adaptive_tangent(nearest(ratio, 1d0), 1d0) /= DC_GAUSS_NEWTON) call fail('more than that is far from it')
        if (dc_adaptive_tangent(0d0, 0d0) /= DC_EXACT) call fail('no residual is equilibrium')
        print '(a)', 'the adaptive tangent switches'
    end subroutine

    subroutine print_bits()
        do e = 1, elements
            call bits('now', [reshape(coords(:, :, e), [freedoms]) + u(:, e)])
            call bits('start', [reshape(coords(:, :, e), [freedoms]) + u(:, e) - (u(:, e) - accepted(:, e))])
            call bits('history', history(:, e))
            call bits('rhs', rhs(:, e))
            call bits('amatrx', reshape(amatrx(:, :, e), [freedoms**2]))
        end do
    end subroutine

    subroutine bits(name, values)
        character(len=*), intent(in) :: name
        real(8), intent(in) :: values(:)
        integer :: k

        write (*, '(a)', advance='no') name
        do k = 1, size(values)
            write (*, '(1x, z16.16)', advance='no') transfer(values(k), 0_int64)
        end do
        write (*, '()')
    end subroutine
end program drive_uel

!> What Abaqus has to end an analysis.
subroutine xit
    stop 2
end subroutine xit
