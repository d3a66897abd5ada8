! Calls uel.f90 as Abaqus does, with a closed plate for a master: a slave is pushed more than half through it.
!
!     gfortran -O2 uel.f90 drive_uel_plate.f90 $(pkg-config --libs diffuse_contact) -o drive_uel_plate && ./drive_uel_plate
!
! In each increment the slave stays on the side where that began, however near the other one is. Ends with stop code 1 if something is
! wrong.
program drive_uel_plate
    implicit none

    integer, parameter :: cells = 8, side = cells + 1, layer = side*side, nodes = 2*layer + 1, facet_count = 2*cells**2 + 4*cells
    real(8), parameter :: thickness = 0.1d0, penalty = 3d3
    integer :: jprops(1 + 4*facet_count)
    real(8) :: coords(3, nodes), svars(12), history(12), force(3)

    open (7, file='/dev/stderr')
    call make_plate()
    history = 0
    ! From above, then from below, each time nearer to the other side: 0.06 deep.
    coords(:, 1) = [4.1d0, 3.8d0, thickness]
    call call_uel(-0.06d0)
    call check('from above', 0.06d0*penalty)
    coords(:, 1) = [4.1d0, 3.8d0, 0d0]
    call call_uel(0.06d0)
    call check('from below', -0.06d0*penalty)

contains

    !> Node 1 is the slave, then come the nodes below and those above.
    subroutine make_plate()
        integer :: k, i, along(side), from(4*cells), to(4*cells)

        do k = 0, layer - 1
            coords(:, k + 2) = [real(mod(k, side), 8), real(k/side, 8), 0d0]
            coords(:, k + 2 + layer) = coords(:, k + 2) + [0d0, 0d0, thickness]
        end do
        jprops(1) = facet_count
        do k = 0, cells**2 - 1
            i = mod(k, cells) + side*(k/cells) + 2
            jprops(8*k + 2:8*k + 5) = [i, i + side, i + side + 1, i + 1]
            jprops(8*k + 6:8*k + 9) = [i, i + 1, i + side + 1, i + side] + layer
        end do
        ! Around the rim, counter-clockwise seen from above.
        along = [(i, i=0, cells)]
        from = [2 + along(:cells), 2 + cells + side*along(:cells), 1 + layer - along(:cells), 2 + side*(cells - along(:cells))]
        to = cshift(from, 1)
        do k = 1, 4*cells
            i = 8*cells**2 + 4*k - 2
            jprops(i:i + 3) = [from(k), to(k), to(k) + layer, from(k) + layer]
        end do
    end subroutine

    !> An increment that moves the slave along z.
    subroutine call_uel(depth)
        real(8), intent(in) :: depth
        real(8) :: rhs(3*nodes, 1), amatrx(3*nodes, 3*nodes), moves(3*nodes, 1), none(3*nodes), props(8), energy(8), pnewdt, &
            predefined(2, 1, nodes), no_loads(1, 1)
        integer :: no_types(1, 1)

        props = 0
        props(1) = penalty
        moves = 0
        moves(3, 1) = depth
        none = 0
        predefined = 0
        no_loads = 0
        no_types = 0
        pnewdt = 1
        svars = history
        call uel(rhs, amatrx, svars, energy, 3*nodes, 1, size(svars), props, size(props), coords, 3, nodes, moves(:, 1), &
            moves, none, none, 1, [0d0, 0d0], 1d0, 1, 1, 1, [0d0], 0, no_types, no_loads, predefined, 1, [1, 1, 1, 0, 0], &
            3*nodes, no_loads, 1, pnewdt, jprops, size(jprops), 1d0)
        force = rhs(1:3, 1)
    end subroutine

    subroutine check(name, expected)
        character(len=*), intent(in) :: name
        real(8), intent(in) :: expected

        print '(2a, 3es12.4, a, es12.4)', name, ': force', force, ', gap', svars(9)
        if (all(abs(force - [0d0, 0d0, expected]) < 1d-10*penalty) .and. abs(svars(9) + 0.06d0) < 1d-12) return
        print '(2a)', 'failed: the slave is pushed through the plate ', name
        stop 1
    end subroutine
end program drive_uel_plate

!> What Abaqus has to end an analysis.
subroutine xit
    stop 2
end subroutine xit
