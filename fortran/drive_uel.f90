! Calls uel.f90 as Abaqus does: a curved rigid surface is pressed against four nodes on springs, and tilted.
!
!     gfortran -O2 uel.f90 drive_uel.f90 $(pkg-config --libs diffuse_contact) -o drive_uel && ./drive_uel
!
! 1. Increments with Newton's method. SVARS are handed over as at the start of the increment, kept when it is accepted, and forgotten
!    when it is cut back; the whole motion is tried at once first, which is too much, so that PNEWDT has to act.
! 2. The tangent of each element is compared with central differences of its forces.
! 3. LFLAGS(3) is honoured: stiffness alone, force alone, neither; the module's structures are those of the library.
!
! Ends with stop code 1 if something is wrong. With the argument --bits it prints all numbers of the last call of each increment and
! element in hexadecimal.
program drive_uel
    use, intrinsic :: iso_fortran_env, only: int64
    implicit none

    integer, parameter :: side = 7, candidates = side*side, nodes = candidates + 1, freedoms = 3*nodes, elements = 4
    integer, parameter :: variables = nodes + 11, unknowns = 3*elements, properties = 8
    real(8), parameter :: spring = 50, travel = 0.9d0, tilt = 0.12d0, tolerance = 1d-10
    real(8), parameter :: props(properties) = [3d3, 0d0, 0d0, 0d0, 0d0, 1d0, 0d0, 0.1d0]

    real(8) :: coords(3, nodes, elements), u(freedoms, elements), &
        accepted(freedoms, elements), rhs(freedoms, elements), amatrx(freedoms, freedoms, elements), &
        history(variables, elements), svars(variables, elements), energy(8), pnewdt, total, dt, worst
    real(8) :: stiffness(unknowns, unknowns), residual(unknowns)
    integer :: increment, attempts, iteration, cutbacks, iterations, e
    logical :: prints_bits
    character(len=16) :: argument

    call get_command_argument(1, argument)
    prints_bits = argument == '--bits'
    open (7, file='/dev/stderr')
    call make_mesh()

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
    call check_flags()
    call check_structures()

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

    !> One call as Abaqus makes it.
    subroutine call_uel(e, kind, displacements, variables_in, force, tangent, variables_out)
        integer, intent(in) :: e, kind
        real(8), intent(in) :: displacements(freedoms), variables_in(variables)
        real(8), intent(out) :: force(freedoms), tangent(freedoms, freedoms), variables_out(variables)
        real(8) :: none(freedoms), predefined(2, 1, nodes), no_loads(1, 1), forces(freedoms, 1), increments(freedoms, 1)
        integer :: flags(5), no_types(1, 1)

        none = 0
        predefined = 0
        no_loads = 0
        no_types = 0
        flags = [1, 1, kind, 0, 0]
        variables_out = variables_in
        increments(:, 1) = displacements - accepted(:, e)
        forces = huge(1d0)
        tangent = huge(1d0)
        call uel(forces, tangent, variables_out, energy, freedoms, 1, variables, props, properties, coords(:, :, e), 3, &
            nodes, displacements, increments, none, none, 1, [total, total], dt, 1, increment, e, [0d0], 0, no_types, &
            no_loads, predefined, 1, flags, freedoms, no_loads, 1, pnewdt, [0], 0, 1d0)
        force = forces(:, 1)
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
            if (maxval(abs(residual)) < tolerance) then
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
                worst = max(worst, maxval(abs(moved - tangent(:, k)))/maxval(abs(tangent)))
            end do
        end do
        print '(a, es8.1)', 'tangent against central differences: ', worst
        if (.not. worst < 1d-8) call fail('the tangent is not the derivative of the force')
    end subroutine

    !> What each kind of call fills.
    subroutine check_flags()
        real(8) :: force(freedoms), tangent(freedoms, freedoms), both(freedoms), whole(freedoms, freedoms), state(variables)

        call call_uel(1, 1, u(:, 1), history(:, 1), both, whole, state)
        call call_uel(1, 2, u(:, 1), history(:, 1), force, tangent, state)
        if (any(force /= 0) .or. any(tangent /= whole)) call fail('LFLAGS(3) = 2 is the stiffness alone')
        if (any(state /= history(:, 1))) call fail('LFLAGS(3) = 2 leaves the history as it is')
        call call_uel(1, 5, u(:, 1), history(:, 1), force, tangent, state)
        if (any(force /= both) .or. any(tangent /= 0)) call fail('LFLAGS(3) = 5 is the force alone')
        call call_uel(1, 4, u(:, 1), history(:, 1), force, tangent, state)
        if (any(force /= 0) .or. any(tangent /= 0)) call fail('LFLAGS(3) = 4 is the mass, which is zero')
        print '(a)', 'flags are honoured'
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
        if (options%radius_factor /= 1.25d0 .or. options%cutback_lost /= 0.01d0) call fail('dc_options is another one')
        if (any([c_sizeof(options), c_sizeof(report), c_sizeof(law), c_sizeof(element), c_sizeof(pairing)] /= &
            [options%size, report%size, law%size, element%size, pairing%size])) call fail('a structure has another size')
        print '(a)', 'structures fit'
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
