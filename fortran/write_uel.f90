! Writes the user elements of an Abaqus input file with windows of the master surface: what each slave can need of it.
!
!     gfortran -O2 write_uel.f90 $(pkg-config --libs diffuse_contact) -o write_uel
!     ./write_uel surfaces.txt >contact.inp          *INCLUDE, INPUT=contact.inp in the input file
!
! The file has keywords and data lines as an input file; ** begins a comment.
!
!     *NODE               label, x, y, z: nodes of the master and slaves, in first positions
!     *FACET              labels of 3 or 4 nodes, counter-clockwise seen from outside: the whole master surface
!     *SLAVE              label, area; 0 for a penalty per node
!     *BOX                how far the box around each slave reaches, in x, y and z: the way that it goes, and the limit of the distance
!     *SKIN               how far nodes of the master move in the whole analysis, with rotations; 0 without this keyword
!     *SYMMETRY           x, y, z of a point of the plane, and of its unit normal to the side of the model
!     *PROPERTY           penalty, weight, coefficient of friction, tangential stiffness, shear limit, limit of the distance
!     *FIRST              label of the first user element; 1 without this keyword
!
! Written are *USER ELEMENT, an *ELEMENT in a set of its own for each slave, SLAVE_label, and its *UEL PROPERTY. All have as many nodes
! as the largest window; others are filled up with nodes of the master that take no part. Ends with stop code 1 and a sentence if
! something is wrong. diffuse_contact.f90 and uel_domains.f90 have to be beside it.
include 'diffuse_contact.f90'
include 'uel_domains.f90'

program write_uel
    use, intrinsic :: iso_fortran_env, only: error_unit
    use, intrinsic :: iso_c_binding
    use diffuse_contact
    use diffuse_contact_domains, only: encoded_window, FRICTION_PROPERTIES
    implicit none

    type :: slave_window
        integer, allocatable :: nodes(:), jprops(:)
    end type

    integer, allocatable :: labels(:), slaves(:)
    integer(c_int32_t), allocatable :: facets(:, :)
    real(8), allocatable :: positions(:, :), areas(:), planes(:, :)
    real(8) :: box(3) = -1, skin = 0, property(6) = -1
    integer :: first_label = 1, line_number = 0, k, nodes, entries
    character(len=256) :: file
    type(slave_window), allocatable :: windows(:)
    type(c_ptr) :: whole

    allocate (labels(0), slaves(0), facets(4, 0), positions(3, 0), areas(0), planes(6, 0))
    call get_command_argument(1, file)
    call read_file()
    call check_file()
    call make_whole()
    allocate (windows(size(slaves)))
    do k = 1, size(slaves)
        call make_window(windows(k), k)
    end do
    nodes = maxval([(size(windows(k)%nodes), k=1, size(slaves))])
    entries = maxval([(size(windows(k)%jprops), k=1, size(slaves))])
    print '(4(a, i0), a)', '*USER ELEMENT, TYPE=U1, NODES=', nodes + 1, ', COORDINATES=3, PROPERTIES=', FRICTION_PROPERTIES, &
        ', I PROPERTIES=', entries, ', VARIABLES=', 3*(nodes + 1) + 11, trim(merge(', UNSYMM', '        ', property(3) > 0))
    print '(a)', '1, 2, 3'
    do k = 1, size(slaves)
        call write_element(windows(k), k)
    end do

contains

    subroutine fail(why, number)
        character(len=*), intent(in) :: why
        integer, intent(in), optional :: number

        if (present(number)) write (error_unit, '(2a, i0)') 'failed: ', why, number
        if (.not. present(number)) write (error_unit, '(2a)') 'failed: ', why
        stop 1
    end subroutine

    subroutine expect(status)
        integer(c_int), intent(in) :: status

        if (status /= DC_OK) call fail(dc_text())
    end subroutine

    subroutine read_file()
        character(len=256) :: line, keyword
        real(8) :: values(8)
        integer :: unit, status, count
        logical :: is_comment

        keyword = ''
        open (newunit=unit, file=file, status='old', action='read', iostat=status)
        if (status /= 0) call fail('there is no file '//trim(file))
        do
            read (unit, '(a)', advance='no', iostat=status) line
            if (status /= 0 .and. .not. is_iostat_eor(status)) exit
            line_number = line_number + 1
            is_comment = line(1:2) == '**'
            ! The end of the line has not come.
            if (status == 0) then
                if (.not. is_comment) call fail('256 characters or more: line ', line_number)
                read (unit, '()', iostat=status)
            end if
            if (is_comment .or. line == '') cycle
            if (line(1:1) == '*') then
                keyword = adjustl(line)
                cycle
            end if
            call read_numbers(line, values, count)
            call take(keyword, values(:count))
        end do
        close (unit)
    end subroutine

    !> Numbers between commas.
    subroutine read_numbers(line, values, count)
        character(len=*), intent(in) :: line
        real(8), intent(out) :: values(:)
        integer, intent(out) :: count
        character(len=len(line)) :: word
        integer :: from, comma, status

        from = 1
        count = 0
        do while (line(from:) /= '')
            comma = index(line(from:), ',')
            if (comma == 0) comma = len(line) - from + 2
            count = count + 1
            if (count > size(values)) call fail('too many numbers: line ', line_number)
            word = adjustl(line(from:from + comma - 2))
            ! Of two words, or behind a slash or an asterisk, a list-directed read would take one and pass over the rest.
            if (verify(trim(word), '0123456789+-.eEdD') > 0) call fail('not a number: line ', line_number)
            read (word, *, iostat=status) values(count)
            if (status /= 0) call fail('not a number: line ', line_number)
            from = from + comma
            if (from > len(line)) exit
        end do
    end subroutine

    subroutine take(keyword, values)
        character(len=*), intent(in) :: keyword
        real(8), intent(in) :: values(:)
        integer :: wanted

        wanted = merge(1, 0, keyword == '*SKIN' .or. keyword == '*FIRST') + merge(2, 0, keyword == '*SLAVE') + &
            merge(3, 0, keyword == '*BOX') + merge(4, 0, keyword == '*NODE' .or. keyword == '*FACET') + &
            merge(6, 0, keyword == '*SYMMETRY' .or. keyword == '*PROPERTY')
        if (wanted == 0) call fail('no such keyword: line ', line_number)
        if (size(values) /= wanted .and. .not. (keyword == '*FACET' .and. size(values) == 3)) &
            call fail('another number of entries: line ', line_number)
        select case (keyword)
        case ('*NODE')
            if (any(labels == label_of(values(1)))) call fail('a second node has the label ', nint(values(1)))
            labels = [labels, label_of(values(1))]
            positions = reshape([positions, values(2:4)], [3, size(labels)])
        case ('*FACET')
            facets = reshape([facets, places(label_of(values)) - 1], [4, size(facets, 2) + 1], pad=[-1])
        case ('*SLAVE')
            slaves = [slaves, places(label_of(values(1:1)))]
            areas = [areas, values(2)]
        case ('*BOX')
            box = values
        case ('*SKIN')
            skin = values(1)
        case ('*SYMMETRY')
            planes = reshape([planes, values], [6, size(planes, 2) + 1])
        case ('*PROPERTY')
            property = values
        case ('*FIRST')
            first_label = label_of(values(1))
        end select
    end subroutine

    !> Labels, which are whole numbers.
    impure elemental integer function label_of(value)
        real(8), intent(in) :: value

        label_of = nint(value)
        if (value /= label_of) call fail('a label is not a whole number: line ', line_number)
    end function

    function places(wanted) result(found)
        integer, intent(in) :: wanted(:)
        integer :: found(size(wanted)), k

        do k = 1, size(wanted)
            found(k) = findloc(labels, wanted(k), 1)
            if (found(k) == 0) call fail('there is no node ', wanted(k))
        end do
    end function

    subroutine check_file()
        if (size(facets) == 0 .or. size(slaves) == 0) call fail('*FACET and *SLAVE are needed')
        if (.not. all(box > 0)) call fail('*BOX with three positive numbers is needed')
        if (.not. property(1) > 0 .or. .not. all(property >= 0)) &
            call fail('*PROPERTY is needed: a positive penalty, and no negative number')
        if (.not. property(6) > 0) call fail('a limit of the distance is needed, the last number of *PROPERTY')
        if (property(6) > minval(box)) call fail('*BOX has to reach as far as the limit of the distance')
    end subroutine

    !> The whole surface, with no slave of interest.
    subroutine make_whole()
        type(dc_options) :: options

        call expect(dc_options_default(options))
        options%weight = nint(property(2))
        call expect(dc_create(positions, int(size(labels), c_size_t), facets, int(size(facets, 2), c_size_t), &
            int(slaves - 1, c_int32_t), int(size(slaves), c_size_t), slave_facet_count=0_c_size_t, options=options, &
            interface=whole))
        if (size(planes) > 0) call expect(dc_set_symmetry(whole, planes, int(size(planes, 2), c_size_t)))
        call expect(dc_update(whole, positions, int(size(labels), c_size_t)))
    end subroutine

    subroutine make_window(window, k)
        type(slave_window), intent(out) :: window
        integer, intent(in) :: k
        type(c_ptr) :: handle
        integer(c_size_t) :: count, integer_count, real_count
        integer(c_int64_t), allocatable :: names(:), integers(:)
        real(8), allocatable :: reals(:)

        associate (x => positions(:, slaves(k)))
            call expect(dc_window_create(whole, [x - box, x + box], 1_c_size_t, skin, handle))
        end associate
        call expect(dc_window_counts(handle, count, integer_count=integer_count, real_count=real_count))
        allocate (names(count), integers(integer_count), reals(real_count))
        call expect(dc_window_names(handle, names, count, facet_count=0_c_size_t))
        call expect(dc_window_numbers(handle, integers, integer_count, reals, real_count))
        call expect(dc_window_destroy(handle))
        if (count == 0) call fail('nothing of the master is within the box of slave ', labels(slaves(k)))
        window%nodes = int(names) + 1
        window%jprops = encoded_window(integers, reals)
    end subroutine

    !> Its lines, 16 entries to a line of nodes, 8 to one of properties.
    subroutine write_element(window, k)
        type(slave_window), intent(in) :: window
        integer, intent(in) :: k
        integer, allocatable :: all_nodes(:)
        real(8) :: props(FRICTION_PROPERTIES)
        character(len=24), allocatable :: texts(:)
        integer :: i

        all_nodes = [slaves(k), window%nodes]
        do i = 1, size(labels)
            if (size(all_nodes) > nodes) exit
            if (any(facets == i - 1) .and. all(all_nodes /= i)) all_nodes = [all_nodes, i]
        end do
        print '(a, i0)', '*ELEMENT, TYPE=U1, ELSET=SLAVE_', labels(slaves(k))
        allocate (texts(nodes + 2))
        write (texts(1), '(i0)') first_label + k - 1
        do i = 1, nodes + 1
            write (texts(i + 1), '(i0)') labels(all_nodes(i))
        end do
        call write_lines(texts, 16, .true.)
        props = [property(1), areas(k), property(2), 0d0, 0d0, 0d0, 0d0, 0d0, 0d0, property(3:6)]
        print '(a, i0)', '*UEL PROPERTY, ELSET=SLAVE_', labels(slaves(k))
        deallocate (texts)
        allocate (texts(size(props) + entries))
        do i = 1, size(props)
            write (texts(i), '(es20.12e3)') props(i)
        end do
        do i = 1, entries
            write (texts(size(props) + i), '(i0)') merge(window%jprops(min(i, size(window%jprops))), 0, i <= size(window%jprops))
        end do
        call write_lines(texts, 8, .false.)
    end subroutine

    !> A comma at the end of a line continues an element.
    subroutine write_lines(texts, most, continues)
        character(len=*), intent(in) :: texts(:)
        integer, intent(in) :: most
        logical, intent(in) :: continues
        integer :: i, j

        do i = 1, size(texts), most
            do j = i, min(i + most - 1, size(texts))
                write (*, '(a)', advance='no') trim(adjustl(texts(j)))
                if (j < min(i + most - 1, size(texts)) .or. continues .and. j < size(texts)) write (*, '(a)', advance='no') ', '
            end do
            write (*, '()')
        end do
    end subroutine
end program write_uel

!> What the element of uel_domains.f90 would call.
subroutine xit
    stop 2
end subroutine xit
