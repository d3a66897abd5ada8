! Reads an Abaqus input file with user elements, checks it, and runs its step with uel.f90.
!
!     gfortran -O2 uel.f90 drive_input.f90 $(pkg-config --libs diffuse_contact) -o drive_input
!     ./drive_input examples/block_on_cylinder.inp
!
! It knows the keywords of that example: *NODE, *NSET, *ELEMENT (C3D8 and U1), *ELASTIC, *USER ELEMENT, *UEL PROPERTY, *STATIC and
! *BOUNDARY; others are skipped. *USER ELEMENT may have I PROPERTIES, and has to say UNSYMM where there is friction. Checked is what uel.f90 and the manual demand of the lines; uel.f90 checks the numbers it is given.
!
! The solid here is linear: bricks with 2 x 2 x 2 points, small strains. Abaqus' C3D8 under NLGEOM is neither. Contact is the same.
!
! Ends with stop code 1 if the file is wrong, a check fails or nothing converges, with 2 if uel.f90 ends the analysis. With the argument --check after the file it only reads.
program drive_input
    implicit none

    ! How many sets, user elements and so on the file may have.
    integer, parameter :: most = 500, most_values = 100, line_length = 256
    real(8), parameter :: tolerance = 1d-9

    !> A user element.
    type :: contact_element
        integer :: label = 0, properties = 0
        character(len=40) :: set = ''
        integer, allocatable :: nodes(:)
        real(8), allocatable :: svars(:), history(:), rhs(:), amatrx(:, :)
    end type

    type :: node_set
        character(len=40) :: name = ''
        integer, allocatable :: nodes(:)
    end type

    type :: property_list
        character(len=40) :: set = ''
        ! PROPS, then JPROPS.
        real(8), allocatable :: values(:)
        integer, allocatable :: integers(:)
    end type

    !> A line of *BOUNDARY.
    type :: prescribed
        integer, allocatable :: nodes(:)
        integer :: first = 0, last = 0
        real(8) :: value = 0
    end type

    integer, allocatable :: labels(:), bricks(:, :)
    real(8), allocatable :: coords(:, :), u(:), accepted(:), stiffness(:, :)
    logical, allocatable :: is_free(:)
    type(contact_element) :: contacts(most)
    type(node_set) :: sets(most)
    type(property_list) :: properties(most)
    type(prescribed) :: conditions(most)
    integer :: contact_count = 0, set_count = 0, property_count = 0, condition_count = 0
    real(8) :: young = 0, poisson = 0, control(4) = 0, pnewdt
    ! Of *USER ELEMENT.
    integer :: told_nodes = 0, told_coordinates = 0, told_properties = 0, told_integers = 0, told_variables = 0, line_number = 0
    logical :: is_unsymmetric = .false.
    character(len=line_length) :: file, option

    open (7, file='/dev/stderr')
    allocate (labels(0), bricks(8, 0), coords(3, 0))
    call get_command_argument(1, file)
    call get_command_argument(2, option)
    call read_input()
    call check_input()
    if (option /= '--check') call run_step()

contains

    subroutine fail(why, number)
        character(len=*), intent(in) :: why
        integer, intent(in), optional :: number

        if (present(number)) write (7, '(2a, i0)') 'failed: ', why, number
        if (.not. present(number)) write (7, '(2a)') 'failed: ', why
        stop 1
    end subroutine

    ! What the file says.

    subroutine read_input()
        character(len=line_length) :: line, keyword, entries(most_values)
        integer :: unit, status, count
        real(8) :: values(most_values)
        logical :: continues

        keyword = ''
        continues = .false.
        count = 0
        open (newunit=unit, file=file, status='old', action='read', iostat=status)
        if (status /= 0) call fail('there is no '//trim(file))
        do
            read (unit, '(a)', iostat=status) line
            if (status /= 0) exit
            line_number = line_number + 1
            if (line(1:2) == '**') cycle
            if (line(1:1) == '*') then
                if (continues) call fail('a line is continued by a keyword: line ', line_number)
                keyword = upper(line)
                call begin(keyword)
                cycle
            end if
            if (.not. continues) count = 0
            call split(line, entries, values, count, continues)
            ! Only the nodes of an element go on after a comma.
            continues = continues .and. name_of(keyword) == '*ELEMENT'
            if (continues) cycle
            call take(keyword, entries, values, count)
        end do
        close (unit)
        if (continues) call fail('the file ends within an element')
    end subroutine

    !> A keyword line.
    subroutine begin(keyword)
        character(len=*), intent(in) :: keyword

        select case (name_of(keyword))
        case ('*USER ELEMENT')
            if (parameter_of(keyword, 'TYPE') /= 'U1') call fail('the user element is not U1: line ', line_number)
            told_nodes = whole(parameter_of(keyword, 'NODES'))
            told_coordinates = whole(parameter_of(keyword, 'COORDINATES'))
            told_properties = whole(parameter_of(keyword, 'PROPERTIES'))
            told_variables = whole(parameter_of(keyword, 'VARIABLES'))
            if (parameter_of(keyword, 'IPROPERTIES') /= '') told_integers = whole(parameter_of(keyword, 'IPROPERTIES'))
            is_unsymmetric = index(pack_blanks(keyword)//',', ',UNSYMM,') > 0
        case ('*ELEMENT')
            if (all(parameter_of(keyword, 'TYPE') /= [character(len=4) :: 'C3D8', 'U1'])) &
                call fail('elements are C3D8 or U1: line ', line_number)
            if (parameter_of(keyword, 'TYPE') == 'U1' .and. told_nodes == 0) &
                call fail('*USER ELEMENT comes after its elements: line ', line_number)
        case ('*UEL PROPERTY')
            call count_up(property_count)
            properties(property_count)%set = parameter_of(keyword, 'ELSET')
            allocate (properties(property_count)%values(0))
        case ('*NODE', '*NSET')
            if (parameter_of(keyword, 'NSET') == '') return
            call count_up(set_count)
            sets(set_count)%name = parameter_of(keyword, 'NSET')
            allocate (sets(set_count)%nodes(0))
        end select
    end subroutine

    subroutine count_up(count)
        integer, intent(inout) :: count

        count = count + 1
        if (count > most) call fail('too much for this program: line ', line_number)
    end subroutine

    !> The data of a keyword: a line, for elements with its continuations.
    subroutine take(keyword, entries, values, count)
        character(len=*), intent(in) :: keyword, entries(:)
        real(8), intent(in) :: values(:)
        integer, intent(in) :: count

        select case (name_of(keyword))
        case ('*NODE')
            if (count /= 4) call fail('a node has a label and three coordinates: line ', line_number)
            labels = [labels, nint(values(1))]
            coords = reshape([coords, values(2:4)], [3, size(labels)])
            if (parameter_of(keyword, 'NSET') /= '') sets(set_count)%nodes = [sets(set_count)%nodes, size(labels)]
        case ('*NSET')
            sets(set_count)%nodes = [sets(set_count)%nodes, places(nint(values(1:count)))]
        case ('*ELEMENT')
            if (parameter_of(keyword, 'TYPE') == 'U1') then
                call count_up(contact_count)
                contacts(contact_count)%label = nint(values(1))
                contacts(contact_count)%set = parameter_of(keyword, 'ELSET')
                contacts(contact_count)%nodes = places(nint(values(2:count)))
            else
                if (count /= 9) call fail('a brick has a label and eight nodes: line ', line_number)
                bricks = reshape([bricks, places(nint(values(2:9)))], [8, size(bricks, 2) + 1])
            end if
        case ('*UEL PROPERTY')
            associate (last => properties(property_count))
                if (mod(size(last%values), 8) /= 0 .or. count > 8) call fail('properties are eight to a line: line ', line_number)
                last%values = [last%values, values(1:count)]
            end associate
        case ('*USER ELEMENT')
            if (count /= 3) call fail('three degrees of freedom: line ', line_number)
            if (any(nint(values(1:3)) /= [1, 2, 3])) call fail('degrees of freedom 1, 2 and 3: line ', line_number)
        case ('*ELASTIC')
            young = values(1)
            poisson = values(2)
        case ('*STATIC')
            control(1:count) = values(1:count)
        case ('*BOUNDARY')
            if (count < 2) call fail('a condition has a set and a degree of freedom: line ', line_number)
            call count_up(condition_count)
            conditions(condition_count)%nodes = nodes_of(entries(1))
            conditions(condition_count)%first = nint(values(2))
            conditions(condition_count)%last = conditions(condition_count)%first
            if (count > 2) conditions(condition_count)%last = nint(values(3))
            if (conditions(condition_count)%first < 1 .or. conditions(condition_count)%last > 3) &
                call fail('degrees of freedom are 1 to 3: line ', line_number)
            if (count > 3) conditions(condition_count)%value = values(4)
        end select
    end subroutine

    !> Adds the entries of a line. Words have the value 0.
    subroutine split(line, entries, values, count, continues)
        character(len=*), intent(in) :: line
        character(len=*), intent(inout) :: entries(:)
        real(8), intent(inout) :: values(:)
        integer, intent(inout) :: count
        logical, intent(out) :: continues
        integer :: from, comma, status, before

        from = 1
        before = count
        do
            ! Nothing after a comma: the line is continued.
            continues = line(from:) == '' .and. count > before
            if (line(from:) == '') exit
            comma = index(line(from:), ',')
            count = count + 1
            if (count > size(values)) call fail('too many entries: line ', line_number)
            entries(count) = adjustl(upper(line(from:merge(from + comma - 2, len(line), comma > 0))))
            read (entries(count), *, iostat=status) values(count)
            if (status /= 0) values(count) = 0
            if (comma == 0) exit
            from = from + comma
        end do
        if (count - before > 16) call fail('a line has more than 16 entries: line ', line_number)
    end subroutine

    !> The keyword without its parameters.
    function name_of(keyword) result(name)
        character(len=*), intent(in) :: keyword
        character(len=40) :: name
        integer :: comma

        comma = index(keyword//',', ',')
        name = keyword(1:comma - 1)
    end function

    !> What a keyword line says of a parameter; nothing if it does not.
    function parameter_of(keyword, name) result(value)
        character(len=*), intent(in) :: keyword, name
        character(len=40) :: value
        character(len=len(keyword) + 1) :: text
        integer :: from, to

        value = ''
        text = pack_blanks(keyword)//','
        from = index(text, ','//name//'=')
        if (from == 0) return
        from = from + len(name) + 2
        to = from + index(text(from:), ',') - 2
        value = text(from:to)
    end function

    function pack_blanks(text) result(packed)
        character(len=*), intent(in) :: text
        character(len=:), allocatable :: packed
        integer :: k

        packed = ''
        do k = 1, len(text)
            if (text(k:k) /= ' ') packed = packed//text(k:k)
        end do
    end function

    integer function whole(text)
        character(len=*), intent(in) :: text
        integer :: status

        read (text, *, iostat=status) whole
        if (status /= 0) call fail('a number is missing: line ', line_number)
    end function

    function upper(text) result(capital)
        character(len=*), intent(in) :: text
        character(len=len(text)) :: capital
        integer :: k

        capital = text
        do k = 1, len(text)
            if (text(k:k) >= 'a' .and. text(k:k) <= 'z') capital(k:k) = achar(iachar(text(k:k)) - 32)
        end do
    end function

    !> Where nodes of these labels stand.
    function places(wanted) result(found)
        integer, intent(in) :: wanted(:)
        integer :: found(size(wanted)), k

        do k = 1, size(wanted)
            found(k) = findloc(labels, wanted(k), 1)
            if (found(k) == 0) call fail('there is no node ', wanted(k))
        end do
    end function

    !> The nodes of a set, or the node of a label.
    function nodes_of(text) result(found)
        character(len=*), intent(in) :: text
        integer, allocatable :: found(:)
        integer :: k

        do k = 1, set_count
            if (sets(k)%name == text) then
                found = sets(k)%nodes
                return
            end if
        end do
        found = places([whole(text)])
    end function

    ! Whether it is consistent.

    subroutine check_input()
        integer :: e, k, slave

        if (told_nodes < 4 .or. told_coordinates /= 3) call fail('*USER ELEMENT: NODES of at least 4, COORDINATES=3')
        if (told_properties < 8) call fail('*USER ELEMENT: PROPERTIES=8 or 9')
        if (told_integers == 0 .and. told_variables < told_nodes + 11) &
            call fail('*USER ELEMENT: VARIABLES of at least the number of nodes and 11')
        if (contact_count == 0 .or. size(bricks) == 0) call fail('there are no elements')
        do e = 1, contact_count
            associate (element => contacts(e))
                if (size(element%nodes) /= told_nodes) call fail('not NODES nodes: user element ', element%label)
                slave = element%nodes(1)
                if (.not. any(bricks == slave)) call fail('the first node belongs to no brick: user element ', element%label)
                do k = 2, told_nodes
                    if (any(bricks == element%nodes(k))) call fail('a candidate belongs to the block: user element ', element%label)
                    if (any(element%nodes(:k - 1) == element%nodes(k))) &
                        call fail('a node is named twice: user element ', element%label)
                end do
                do k = 1, e - 1
                    if (contacts(k)%nodes(1) == slave .or. contacts(k)%label == element%label) &
                        call fail('slave or label are those of another one: user element ', element%label)
                end do
                element%properties = 0
                do k = 1, property_count
                    if (properties(k)%set == element%set) element%properties = k
                end do
                if (element%properties == 0) call fail('no *UEL PROPERTY: user element ', element%label)
            end associate
        end do
        do k = 1, property_count
            associate (own => properties(k))
                if (size(own%values) /= told_properties + told_integers) call fail('not PROPERTIES values: *UEL PROPERTY ', k)
                own%integers = nint(own%values(told_properties + 1:))
                if (any(own%values(told_properties + 1:) /= own%integers)) call fail('I PROPERTIES are whole: *UEL PROPERTY ', k)
                own%values = own%values(:told_properties)
                if (told_properties >= 10 .and. .not. is_unsymmetric) then
                    if (own%values(10) > 0) call fail('friction needs UNSYMM: *UEL PROPERTY ', k)
                end if
            end associate
        end do
        if (condition_count == 0 .or. control(2) <= 0) call fail('there is no step')
        print '(4(i0, a))', size(labels), ' nodes, ', size(bricks, 2), ' bricks, ', contact_count, &
            ' user elements of ', told_nodes, ' nodes'
    end subroutine

    ! The step.

    subroutine run_step()
        real(8) :: total, dt
        integer :: increment, attempts, iterations, cutbacks, pairings, e

        allocate (u(3*size(labels)), accepted(3*size(labels)), is_free(3*size(labels)))
        allocate (stiffness(size(u), size(u)))
        call assemble_bricks()
        accepted = 0
        do e = 1, contact_count
            allocate (contacts(e)%rhs(3*told_nodes), contacts(e)%amatrx(3*told_nodes, 3*told_nodes))
            allocate (contacts(e)%svars(told_variables), contacts(e)%history(told_variables), source=0d0)
        end do
        total = 0
        dt = control(1)
        increment = 1
        cutbacks = 0
        pairings = 0
        do attempts = 1, 100
            dt = min(dt, control(4), control(2) - total)
            call solve_increment(total, dt, increment, iterations)
            if (iterations == 0) then
                dt = dt*min(pnewdt, 0.5d0)
                cutbacks = cutbacks + 1
                if (dt < control(3)) call fail('the increment is too small')
                cycle
            end if
            total = total + dt
            do e = 1, contact_count
                if (told_integers == 0 .and. increment > 1 .and. contacts(e)%svars(8) /= contacts(e)%history(8)) &
                    pairings = pairings + 1
                contacts(e)%history = contacts(e)%svars
            end do
            accepted = u
            print '(a, i0, a, f0.4, a, i0, a, es20.12)', 'increment ', increment, ' to ', total, ': ', iterations, &
                ' iterations, force', sum([(contacts(e)%svars(10), e=1, contact_count)])
            if (total > control(2)*(1 - 1d-12)) exit
            increment = increment + 1
            dt = 1.5d0*dt
        end do
        if (total < control(2)*(1 - 1d-12)) call fail('too many increments')
        print '(i0, a, i0, a)', cutbacks, ' cut-backs, ', pairings, ' pairings renewed'
        call check_results()
    end subroutine

    !> Newton's method. iterations is 0 if it is to be cut back.
    subroutine solve_increment(total, dt, increment, iterations)
        real(8), intent(in) :: total, dt
        integer, intent(in) :: increment
        integer, intent(out) :: iterations
        real(8) :: residual(size(u)), tangent(size(u), size(u))
        integer :: k

        u = accepted
        call prescribe(total + dt)
        pnewdt = 1
        do k = 1, 16
            call assemble(total, dt, increment, residual, tangent)
            if (pnewdt < 1) exit
            if (all(abs(residual) < tolerance .or. .not. is_free)) then
                iterations = k
                return
            end if
            call correct(residual, tangent)
        end do
        iterations = 0
    end subroutine

    !> Displacements that are prescribed, in proportion to time; a later line prevails.
    subroutine prescribe(time)
        real(8), intent(in) :: time
        integer :: c, k, axis

        is_free = .false.
        ! Nodes of no brick have no stiffness.
        do k = 1, size(labels)
            is_free(3*k - 2:3*k) = any(bricks == k)
        end do
        do c = 1, condition_count
            do axis = conditions(c)%first, conditions(c)%last
                do k = 1, size(conditions(c)%nodes)
                    u(3*(conditions(c)%nodes(k) - 1) + axis) = conditions(c)%value*time/control(2)
                    is_free(3*(conditions(c)%nodes(k) - 1) + axis) = .false.
                end do
            end do
        end do
    end subroutine

    !> Residual (forces that are not in balance) and tangent.
    subroutine assemble(total, dt, increment, residual, tangent)
        real(8), intent(in) :: total, dt
        integer, intent(in) :: increment
        real(8), intent(out) :: residual(:), tangent(:, :)
        integer :: e

        residual = -matmul(stiffness, u)
        tangent = stiffness
        do e = 1, contact_count
            call call_uel(contacts(e), total, dt, increment)
            associate (own => freedoms(contacts(e)%nodes))
                residual(own) = residual(own) + contacts(e)%rhs
                tangent(own, own) = tangent(own, own) + contacts(e)%amatrx
            end associate
        end do
    end subroutine

    pure function freedoms(nodes) result(own)
        integer, intent(in) :: nodes(:)
        integer :: own(3*size(nodes)), k

        own = [(3*nodes(k) - 2, 3*nodes(k) - 1, 3*nodes(k), k=1, size(nodes))]
    end function

    !> A call as Abaqus makes it in a static step.
    subroutine call_uel(element, total, dt, increment)
        type(contact_element), intent(inout) :: element
        real(8), intent(in) :: total, dt
        integer, intent(in) :: increment
        real(8) :: none(3*told_nodes), predefined(2, 1, told_nodes), no_loads(1, 1), energy(8), forces(3*told_nodes, 1), &
            moved(3*told_nodes, 1)
        integer :: no_types(1, 1), own(3*told_nodes)

        none = 0
        predefined = 0
        no_loads = 0
        no_types = 0
        own = freedoms(element%nodes)
        moved(:, 1) = u(own) - accepted(own)
        element%svars = element%history
        call uel(forces, element%amatrx, element%svars, energy, size(own), 1, told_variables, &
            properties(element%properties)%values, told_properties, coords(:, element%nodes), told_coordinates, told_nodes, &
            u(own), moved, none, none, 1, [total, total], dt, 1, increment, element%label, [0d0], 0, no_types, no_loads, &
            predefined, 1, [1, 1, 1, 0, 0], size(own), no_loads, 1, pnewdt, &
            properties(element%properties)%integers, told_integers, control(2))
        element%rhs = forces(:, 1)
    end subroutine

    !> u of the free degrees of freedom, by elimination with pivoting.
    subroutine correct(residual, tangent)
        real(8), intent(in) :: residual(:), tangent(:, :)
        integer, allocatable :: free(:)
        real(8), allocatable :: a(:, :), b(:), held(:)
        integer :: k, row, pivot

        free = pack([(k, k=1, size(u))], is_free)
        a = tangent(free, free)
        b = residual(free)
        do k = 1, size(b)
            pivot = k - 1 + maxloc(abs(a(k:, k)), 1)
            held = a(k, :)
            a(k, :) = a(pivot, :)
            a(pivot, :) = held
            b([k, pivot]) = b([pivot, k])
            do row = k + 1, size(b)
                b(row) = b(row) - a(row, k)/a(k, k)*b(k)
                a(row, k:) = a(row, k:) - a(row, k)/a(k, k)*a(k, k:)
            end do
        end do
        do row = size(b), 1, -1
            b(row) = (b(row) - dot_product(a(row, row + 1:), b(row + 1:)))/a(row, row)
        end do
        u(free) = u(free) + b
    end subroutine

    !> Stiffness of the bricks: linear elasticity, 2 x 2 x 2 points.
    subroutine assemble_bricks()
        real(8), parameter :: signs(3, 8) = reshape([-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, &
            -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1]*1d0, [3, 8])
        real(8) :: slopes(3, 8), jacobian(3, 3), inverse(3, 3), determinant, strains(6, 24), law(6, 6), at(3)
        integer :: e, point, k

        law = 0
        law(1:3, 1:3) = poisson
        do k = 1, 3
            law(k, k) = 1 - poisson
            law(k + 3, k + 3) = 0.5d0 - poisson
        end do
        law = law*young/((1 + poisson)*(1 - 2*poisson))
        stiffness = 0
        do e = 1, size(bricks, 2)
            do point = 1, 8
                at = signs(:, point)/sqrt(3d0)
                do k = 1, 8
                    associate (s => signs(:, k), one => 1 + signs(:, k)*at)
                        slopes(:, k) = s*[one(2)*one(3), one(1)*one(3), one(1)*one(2)]/8
                    end associate
                end do
                jacobian = matmul(slopes, transpose(coords(:, bricks(:, e))))
                call invert(jacobian, inverse, determinant)
                if (determinant <= 0) call fail('inside out: brick ', e)
                slopes = matmul(inverse, slopes)
                strains = 0
                do k = 1, 8
                    associate (x => 3*k - 2, y => 3*k - 1, z => 3*k, d => slopes(:, k))
                        strains(1, x) = d(1)
                        strains(2, y) = d(2)
                        strains(3, z) = d(3)
                        strains(4, [x, y]) = [d(2), d(1)]
                        strains(5, [x, z]) = [d(3), d(1)]
                        strains(6, [y, z]) = [d(3), d(2)]
                    end associate
                end do
                associate (own => freedoms(bricks(:, e)))
                    stiffness(own, own) = stiffness(own, own) + determinant*matmul(transpose(strains), matmul(law, strains))
                end associate
            end do
        end do
    end subroutine

    pure subroutine invert(a, inverse, determinant)
        real(8), intent(in) :: a(3, 3)
        real(8), intent(out) :: inverse(3, 3), determinant
        integer :: i, j

        do i = 1, 3
            associate (i1 => mod(i, 3) + 1, i2 => mod(i + 1, 3) + 1)
                do j = 1, 3
                    associate (j1 => mod(j, 3) + 1, j2 => mod(j + 1, 3) + 1)
                        inverse(j, i) = a(i1, j1)*a(i2, j2) - a(i1, j2)*a(i2, j1)
                    end associate
                end do
            end associate
        end do
        determinant = dot_product(a(1, :), inverse(:, 1))
        inverse = inverse/determinant
    end subroutine

    !> Whether what has converged is contact: all slaves carry force, and forces and moments of each element sum up to nothing.
    subroutine check_results()
        real(8) :: force(3), moment(3), x(3), reaction(size(u)), size_of_forces
        integer :: e, k, node

        reaction = matmul(stiffness, u)
        do e = 1, contact_count
            associate (element => contacts(e))
                if (.not. (element%svars(1) > 0 .and. element%svars(9) < 0 .and. element%svars(10) > 0)) &
                    call fail('there is no contact: user element ', element%label)
                if (element%svars(12) /= 0 .or. told_integers == 0 .and. element%svars(4) /= 2) &
                    call fail('no quadratic fit: user element ', element%label)
                force = 0
                moment = 0
                do k = 1, told_nodes
                    node = element%nodes(k)
                    associate (f => element%rhs(3*k - 2:3*k))
                        x = coords(:, node) + u(3*node - 2:3*node)
                        force = force + f
                        moment = moment + cshift(x, 1)*cshift(f, -1) - cshift(x, -1)*cshift(f, 1)
                    end associate
                end do
                size_of_forces = sum(abs(element%rhs))
                if (.not. (all(abs(force) < 1d-12*size_of_forces) .and. all(abs(moment) < 1d-11*size_of_forces))) &
                    call fail('forces and moments are not in balance: user element ', element%label)
                call print_slave(element)
            end associate
        end do
        force = 0
        do e = 1, contact_count
            force = force + contacts(e)%rhs(1:3)
        end do
        ! What holds the block at its top presses on the slaves.
        x = [(sum(reaction(k::3), mask=.not. is_free(k::3)), k=1, 3)]
        if (.not. all(abs(x + force) < 1d-6*maxval(abs(force)))) call fail('the block is not in balance')
        print '(a, 3es20.12)', 'force on the block', force
    end subroutine

    subroutine print_slave(element)
        type(contact_element), intent(in) :: element
        character(len=5), parameter :: states(0:2) = [character(len=5) :: 'open', 'stick', 'slip']

        write (*, '(a, i0, a, es20.12, a, es20.12)', advance='no') 'slave ', labels(element%nodes(1)), ': gap', element%svars(9), &
            ', force', element%svars(10)
        if (told_integers == 0) then
            print '(a, i0, a)', ', ', nint(element%svars(2)), ' masters'
        else
            print '(3a, 3es20.12)', ', ', trim(states(nint(element%svars(4)))), ', friction', element%svars(5:7)
        end if
    end subroutine
end program drive_input

!> What Abaqus has to end an analysis.
subroutine xit
    stop 2
end subroutine xit
