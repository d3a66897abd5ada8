! The diffuse contact element as an Abaqus user element: one element for each slave node.
!
!     *USER ELEMENT, TYPE=U1, NODES=26, COORDINATES=3, PROPERTIES=8, VARIABLES=37
!     1, 2, 3
!
! examples/block_on_cylinder.inp is a whole input file, block_on_cylinder_friction.inp one with facets and friction.
!
! Nodes: 1 the slave; 2 ... NNODE the candidates, every master node that may come to carry the surface under the slave in the whole
! analysis: all within the way it slides and two or three rows of nodes more on each side. Nodes that take no part get zeros. A
! slave that comes to lie outside its candidates has no contact.
!
! With I PROPERTIES there are facets, and what follows is said under "With facets" below. Without them masters are those of the first
! hull layers around the slave (DC_HULL_LAYERS): domains of influence belong to the nodes of a surface.
!
!     PROPS(1)     penalty, force per length (per length^3 with an area), positive
!     PROPS(2)     tributary area of the slave; 0 for a penalty per node
!     PROPS(3)     weight of the fit: 0 cubic, 1 cubic interpolating, 2 Wendland C2
!     PROPS(4:6)   a direction to the outward side of the master at the beginning
!     PROPS(7)     tangent: 0 exact, 1 Gauss-Newton. A user element is not told the residual of the model, so that it cannot switch
!                  as dc_adaptive_tangent does: where a stiff penalty diverges, take 1
!     PROPS(8)     a penetration deeper than this fraction of the support radius asks for a cut-back; 0 for 0.25
!     PROPS(9)     with PROPERTIES=9: the regularity that the fit of a pairing has to exceed, below 1 (smallest_regularity); 0 for the
!                  library's default. More lets errors in the heights of the masters through less and takes more masters
!
! The pairing is history. Abaqus hands over SVARS as they were at the start of the increment, so that it is held in all iterations
! of an increment, and is what it was after a cut-back. What is returned is the pairing for the next increment.
!
!     SVARS(1)     0 at the beginning, 1 paired, 2 not paired
!     SVARS(2)     number n of masters
!     SVARS(3)     support radius
!     SVARS(4)     basis: 1 linear, 2 quadratic
!     SVARS(5:7)   outward normal
!     SVARS(8)     the candidate that was nearest when it was paired; another one being nearest, it is paired anew
!     SVARS(9)     gap, for output; 0 without contact
!     SVARS(10)    contact force, for output
!     SVARS(11)    dc_outcome, for output: 0 for a result
!     SVARS(12)    dc_fallback of the pairing
!     SVARS(12+k)  the k-th master as a candidate counted from 1; NSVARS is at least NNODE + 11
!
! With facets masters are those of domains of influence (DC_DOMAINS), the library's default, and there is friction:
!
!     *USER ELEMENT, TYPE=U1, NODES=64, COORDINATES=3, PROPERTIES=13, I PROPERTIES=193, VARIABLES=203, UNSYMM
!
!     JPROPS       the number of facets, then four nodes for each, counter-clockwise seen from outside: k is the k-th node of the
!                  element, 0 the fourth of a triangle. They are the whole master surface, and its nodes the candidates. Or a window
!                  of the surface, as write_uel.f90 writes it: -1 and its numbers; nodes 2 and following are those of the window
!     PROPS(1:8)   as above; PROPS(4:6) are not looked at, PROPS(9) is 0
!     PROPS(10)    coefficient of friction; 0, or PROPERTIES below 10: none
!     PROPS(11)    tangential stiffness, in units of the penalty; 0 for the penalty
!     PROPS(12)    shear limit, force (per area with an area); 0 for none
!     PROPS(13)    slaves farther from the master have no contact, length; 0 for no limit
!
!     SVARS(1)     0 at the beginning, 3 afterwards
!     SVARS(2)     how many numbers of history there are from SVARS(13) on, the anchor of friction as dc_history gives it; NSVARS is at
!                  least 3 NNODE + 11 with friction, 12 without. All other SVARS are for output:
!     SVARS(3)     support radius
!     SVARS(4)     0 open, 1 sticks, 2 slides
!     SVARS(5:7)   force of friction on the slave
!     SVARS(8)     work of friction until now
!     SVARS(9:12)  as above
!
! ENERGY(2) is what the penalties store, ENERGY(4), plastic dissipation, the work of friction.
!
! RHS = f N is the contact force on the nodes, AMATRX = K = -d RHS/dU = e N N^T - f M, f = -e g > 0; both zero where nothing touches.
!
!     LFLAGS(3)    general step (LFLAGS(4) = 0)        linear perturbation step (LFLAGS(4) = 1)
!     1            RHS, AMATRX, SVARS, PNEWDT          RHS = -K DU, AMATRX, about the base state U
!     2            AMATRX                              AMATRX
!     3, 4         zeros: no damping, no mass          zeros
!     5            RHS                                 RHS = -K DU
!     100          -                                   RHS(:, k) = -K DU(:, k) for each of NRHS columns, no AMATRX
!
! A perturbation is linear about contacts as they are in the base state: those that touch go on to, the others do not come to. It leaves
! SVARS, the base state, as they are. A second column of RHS (Riks) is zero: contact is no load.
!
! In a general step with LFLAGS(3) = 1 positions that are no numbers, or a force that overflows, ask for a smaller increment: zeros, SVARS
! as they were, PNEWDT at most 0.25, and a message. Other calls with such positions end the analysis.
!
! Static and other procedures without inertia; a dynamic one (LFLAGS(1) = 11, 12, 13) ends the analysis with a message, as do any other
! LFLAGS(3), wrong sizes and SVARS that are not this element's. Compile with diffuse_contact.f90 and uel_domains.f90 beside it and link
! libdiffuse_contact.
include 'diffuse_contact.f90'
include 'uel_domains.f90'

subroutine uel(rhs, amatrx, svars, energy, ndofel, nrhs, nsvars, props, nprops, coords, mcrd, nnode, u, du, v, a, &
        jtype, time, dtime, kstep, kinc, jelem, params, ndload, jdltyp, adlmag, predef, npredf, lflags, mlvarx, &
        ddlmag, mdload, pnewdt, jprops, njprop, period)
    use, intrinsic :: iso_c_binding, only: c_double, c_int, c_int32_t, c_size_t
    use diffuse_contact
    use diffuse_contact_domains
    implicit none

    integer, intent(in) :: ndofel, nrhs, nsvars, nprops, mcrd, nnode, jtype, kstep, kinc, jelem, ndload, npredf, &
        mlvarx, mdload, njprop
    integer, intent(in) :: lflags(*), jdltyp(mdload, *), jprops(*)
    real(8), intent(in) :: props(*), coords(mcrd, nnode), u(ndofel), du(mlvarx, *), v(ndofel), a(ndofel), time(2), &
        dtime, params(*), adlmag(mdload, *), predef(2, npredf, nnode), ddlmag(mdload, *), period
    real(8), intent(inout) :: rhs(mlvarx, *), amatrx(ndofel, ndofel), svars(*), energy(8), pnewdt

    integer, parameter :: before_masters = 12
    real(8), parameter :: least_cutback = 0.1d0
    real(8) :: now(3, nnode), start(3, nnode), given(nsvars), limit, depth
    type(dc_element) :: element
    type(dc_options) :: options
    type(dc_pairing) :: pairing
    type(dc_point) :: point
    integer(c_int32_t) :: masters(nnode)
    integer :: anchor
    logical :: has_facets, is_paired, is_perturbation, ends_increment, wants_force, wants_stiffness, has_result, is_lost

    has_facets = .false.
    if (njprop > 0) has_facets = jprops(1) /= 0
    call check_input()
    is_perturbation = lflags(4) /= 0 .or. lflags(3) == 100
    ! Only a call for an increment's force and stiffness ends in the state at the end of it.
    ends_increment = lflags(3) == 1 .and. .not. is_perturbation
    wants_force = any(lflags(3) == [1, 5, 100])
    wants_stiffness = any(lflags(3) == [1, 2])

    rhs(1:ndofel, 1:nrhs) = 0
    amatrx = 0
    if (ends_increment .or. is_perturbation) energy = 0
    if (.not. (wants_force .or. wants_stiffness)) return

    now = coords(1:3, :) + reshape(u, [3, nnode])
    start = now
    ! In a perturbation step U is the base state, and DU is not in it.
    if (.not. is_perturbation) start = now - reshape(du(1:ndofel, 1), [3, nnode])

    if (has_facets) then
        ! In the first increment these are COORDS, without rounding.
        if (.not. is_perturbation) start = coords(1:3, :) + reshape(u - du(1:ndofel, 1), [3, nnode])
        call run_contact_call(contact_call(jelem, ends_increment, is_perturbation, wants_force, wants_stiffness), &
            coords(1:3, :), now, start, du(1:ndofel, 1:nrhs), props(1:nprops), jprops(1:njprop), svars(1:nsvars), &
            rhs(1:ndofel, 1:nrhs), amatrx, energy, pnewdt)
        return
    end if
    is_lost = .false.
    given = svars(1:nsvars)
    call read_pairing()
    if (.not. is_paired) call pair_at(start)
    has_result = .false.
    if (is_paired) call evaluate()
    if (ends_increment .and. .not. is_lost) call write_pairing()
    if (is_lost) call ask_for_less()

contains

    !> Ends the analysis if the element is not defined as it has to be.
    subroutine check_input()
        character(len=*), parameter :: needs(*) = [character(len=72) :: &
            'at least 4 nodes of 3 displacements each', &
            'COORDINATES=3', &
            'PROPERTIES=8, or more', &
            'VARIABLES of at least the number of nodes and 11', &
            'a positive penalty PROPS(1), and PROPS(2) and PROPS(8) not negative', &
            'PROPS(3) 0, 1 or 2 and PROPS(7) 0 or 1', &
            'a direction PROPS(4:6), finite and not zero', &
            'PROPS(9), where there is one, of at least 0 and below 1', &
            'a procedure without inertia', &
            'LFLAGS(3) of 1, 2, 3, 4, 5 or 100', &
            'SVARS that it has written itself, or zeros', &
            'facets in JPROPS for friction, PROPS(10)']
        logical :: is_met(size(needs))
        character(len=120) :: demand
        integer :: k

        is_met = .true.
        is_met(1) = nnode >= 4 .and. ndofel == 3*nnode .and. mlvarx >= ndofel
        is_met(2) = mcrd >= 3
        is_met(3) = nprops >= 8
        is_met(4) = has_facets .or. nsvars >= nnode + before_masters - 1
        if (is_met(3)) then
            is_met(5) = props(1) > 0 .and. props(2) >= 0 .and. props(8) >= 0
            is_met(6) = any(props(3) == [0d0, 1d0, 2d0]) .and. any(props(7) == [0d0, 1d0])
            is_met(7) = has_facets .or. all(abs(props(4:6)) <= huge(1d0)) .and. any(abs(props(4:6)) > 0)
        end if
        ! NaN is a coefficient, too.
        if (nprops >= 10) is_met(12) = has_facets .or. abs(props(10)) <= 0
        if (nprops >= 9) is_met(8) = props(9) >= 0 .and. props(9) < 1
        is_met(9) = all(lflags(1) /= [11, 12, 13])
        is_met(10) = any(lflags(3) == [1, 2, 3, 4, 5, 100])
        if (is_met(1) .and. is_met(4) .and. .not. has_facets) is_met(11) = is_own_history()
        do k = 1, size(needs)
            if (.not. is_met(k)) call refuse(trim(needs(k)))
        end do
        if (.not. has_facets) return
        call find_unmet_demand(nnode, svars(1:nsvars), nsvars, props(1:nprops), nprops, jprops(1:njprop), njprop, demand)
        if (demand /= '') call refuse(trim(demand))
    end subroutine

    subroutine refuse(demand)
        character(len=*), intent(in) :: demand

        write (7, '(a, i0, 2a)') 'diffuse contact: element ', jelem, ' needs ', demand
        call xit
    end subroutine

    !> Whether SVARS can be what write_pairing wrote: they become indices and lengths.
    logical function is_own_history()
        integer :: k, n

        is_own_history = any(svars(1) == [0d0, 1d0, 2d0])
        if (.not. is_own_history .or. svars(1) == 0) return
        is_own_history = all(abs(svars(5:7)) <= huge(1d0)) .and. any(abs(svars(5:7)) > 0)
        if (.not. is_own_history .or. svars(1) == 2) return
        is_own_history = is_whole(svars(2), 3, nnode - 1) .and. is_whole(svars(4), DC_LINEAR, DC_QUADRATIC) .and. &
            is_whole(svars(8), 1, nnode - 1) .and. is_whole(svars(12), DC_NO_FALLBACK, DC_LINEAR_BASIS) .and. &
            svars(3) > 0 .and. svars(3) <= huge(1d0)
        if (.not. is_own_history) return
        n = int(svars(2))
        is_own_history = svars(4) == DC_LINEAR .or. n >= 6
        ! They ascend.
        do k = 1, n
            is_own_history = is_own_history .and. is_whole(svars(before_masters + k), 1, nnode - 1)
            if (k > 1) is_own_history = is_own_history .and. svars(before_masters + k) > svars(before_masters + k - 1)
        end do
    end function

    !> Whether a number is a whole one within these bounds; NaN is not.
    pure logical function is_whole(value, least, most)
        real(8), intent(in) :: value
        integer, intent(in) :: least, most

        is_whole = value >= least .and. value <= most
        if (is_whole) is_whole = value == nint(value)
    end function

    !> The pairing at the start of the increment.
    subroutine read_pairing()
        integer :: k

        is_paired = svars(1) == 1
        pairing%normal = props(4:6)
        anchor = 0
        if (svars(1) /= 0) pairing%normal = svars(5:7)
        if (.not. is_paired) return
        pairing%master_count = int(svars(2), c_int32_t)
        pairing%support_radius = svars(3)
        pairing%basis = int(svars(4), c_int32_t)
        pairing%fallback = int(svars(12), c_int32_t)
        anchor = int(svars(8))
        do k = 1, pairing%master_count
            masters(k) = int(svars(before_masters + k), c_int32_t)
        end do
    end subroutine

    !> Pairs the slave with candidates at these positions.
    subroutine pair_at(positions)
        real(8), intent(in) :: positions(3, nnode)
        type(dc_pairing) :: found
        integer(c_int) :: status

        status = dc_options_default(options)
        call stop_unless(status == DC_OK)
        if (nprops >= 9) then
            if (props(9) > 0) options%smallest_regularity = props(9)
        end if
        status = dc_pair(options, slave=positions(:, 1), candidates=positions(:, 2:), candidate_count=int(nnode - 1, c_size_t), &
            outward=pairing%normal, masters=masters, capacity=int(nnode, c_size_t), pairing=found)
        is_paired = .false.
        call attempt(status)
        if (is_lost) return
        ! A direction in the plane of the masters has no outward side: without a history it is PROPS(4:6), and a mistake.
        if (status == DC_NO_CONTACT .and. svars(1) == 0) call stop_unless(index(dc_text(), 'ambiguous-outward') == 0)
        ! Beyond the border of the masters the fit is an extrapolation.
        is_paired = status == DC_OK .and. found%encloses_slave == 1
        if (.not. is_paired) return
        pairing = found
        masters(1:pairing%master_count) = masters(1:pairing%master_count) + 1
        anchor = nearest_candidate(positions)
    end subroutine

    !> The candidate nearest to the slave.
    integer function nearest_candidate(positions)
        real(8), intent(in) :: positions(3, nnode)
        real(8) :: squares(nnode - 1)
        integer :: node

        do node = 2, nnode
            squares(node - 1) = sum((positions(:, node) - positions(:, 1))**2)
        end do
        nearest_candidate = minloc(squares, 1)
    end function

    !> Gap, force and stiffness with the pairing held, and whether the increment had better be smaller.
    subroutine evaluate()
        real(c_double) :: gradient(3*(pairing%master_count + 1))
        real(c_double) :: hessian(size(gradient)*(size(gradient) + 1)/2)
        real(c_double) :: residual(size(gradient)), tangent(size(gradient), size(gradient)), force, area
        integer(c_size_t) :: count, freedoms, packed
        integer(c_int) :: status
        integer :: places(3, pairing%master_count + 1), k
        type(dc_law) :: law

        count = pairing%master_count
        freedoms = size(gradient)
        packed = size(hessian)
        element%basis = pairing%basis
        element%weight = int(props(3), c_int32_t)
        element%support_radius = pairing%support_radius
        element%outward = pairing%normal
        status = dc_gap(element, now(:, 1), now(:, 1 + masters(1:count)), count, int(DC_HESSIAN, c_int32_t), point, &
            gradient, freedoms, hessian, packed)
        call attempt(status)
        if (is_lost) return
        has_result = status == DC_OK
        limit = merge(props(8), 0.25d0, props(8) > 0)
        if (.not. has_result) then
            ! A contact that has no foot any more: the increment is too large.
            if (svars(1) == 1 .and. svars(9) < 0) then
                call suggest(merge(0.5d0, 0.25d0, point%outcome == DC_FOOT_OUTSIDE))
            end if
            return
        end if
        depth = -point%gap/pairing%support_radius
        if (depth > limit) call suggest(max(least_cutback, limit/depth))

        law%penalty = props(1)
        law%tangent = int(props(7), c_int32_t)
        area = merge(props(2), 1d0, props(2) > 0)
        status = dc_element_system(law, point%gap, area, count, gradient, hessian, force, residual, freedoms, tangent, &
            freedoms**2)
        call attempt(status)
        if (is_lost) return
        if (ends_increment) then
            svars(10) = force
            energy(2) = -0.5d0*force*point%gap
        end if

        ! Where the element's own degrees of freedom stand among those of all candidates.
        places(:, 1) = [1, 2, 3]
        do k = 1, pairing%master_count
            places(:, k + 1) = 3*masters(k) + [1, 2, 3]
        end do
        associate (own => reshape(places, [size(gradient)]))
            if (wants_stiffness) amatrx(own, own) = tangent
            if (.not. is_perturbation) then
                if (wants_force) rhs(own, 1) = residual
            else
                if (wants_force) then
                    do k = 1, nrhs
                        rhs(own, k) = -matmul(tangent, du(own, k))
                    end do
                end if
                ! By how much the energy changes.
                energy(2) = -dot_product(residual, du(own, 1)) + 0.5d0*dot_product(du(own, 1), matmul(tangent, du(own, 1)))
            end if
        end associate
    end subroutine

    !> Asks for a smaller increment.
    subroutine suggest(factor)
        real(8), intent(in) :: factor

        if (ends_increment) pnewdt = min(pnewdt, factor)
    end subroutine

    !> The pairing for the next increment: the same while the nearest candidate is the same.
    subroutine write_pairing()
        integer :: k

        svars(9) = merge(point%gap, 0d0, has_result)
        if (.not. has_result) svars(10) = 0
        svars(11) = merge(real(point%outcome, 8), real(DC_NOT_PAIRED, 8), is_paired)
        if (has_result) then
            ! The masters may have turned.
            pairing%normal = point%normal
            if (nearest_candidate(now) /= anchor) call pair_at(now)
        else
            call pair_at(now)
        end if
        svars(1) = merge(1d0, 2d0, is_paired)
        svars(5:7) = pairing%normal
        if (.not. is_paired) return
        svars(2) = pairing%master_count
        svars(3) = pairing%support_radius
        svars(4) = pairing%basis
        svars(8) = anchor
        svars(12) = pairing%fallback
        do k = 1, pairing%master_count
            svars(before_masters + k) = masters(k)
        end do
    end subroutine

    !> An iteration that diverges has positions or forces that are no numbers: a smaller increment may help.
    subroutine attempt(status)
        integer(c_int), intent(in) :: status

        is_lost = ends_increment .and. (status == DC_NOT_FINITE .or. status == DC_OVERFLOW)
        if (is_lost) then
            write (7, '(a, i0, 2a)') 'diffuse contact: element ', jelem, ': ', dc_text()
        else
            call stop_unless(status == DC_OK .or. status == DC_NO_CONTACT)
        end if
    end subroutine

    !> A smaller increment, which begins where this one did.
    subroutine ask_for_less()
        svars(1:nsvars) = given
        rhs(1:ndofel, 1:nrhs) = 0
        amatrx = 0
        energy = 0
        call suggest(0.25d0)
    end subroutine

    !> Ends the analysis with the library's message.
    subroutine stop_unless(is_met)
        logical, intent(in) :: is_met

        if (is_met) return
        write (7, '(a, i0, 2a)') 'diffuse contact: element ', jelem, ': ', dc_text()
        call xit
    end subroutine
end subroutine uel
