"""Contact integrated over faces: patch test, balance, tangent, refusals."""

import copy
import itertools

import numpy as np
import pytest

import diffuse_contact as dc

PENALTY = 50.0


def grid(cells, first, place, *, up):
    """Nodes and facets of a grid over [0, 6]², seen from above or from below."""
    x, y = np.meshgrid(np.linspace(0.0, 6.0, cells + 1), np.linspace(0.0, 6.0, cells + 1))
    k = np.arange(cells * cells)
    corner = first + k % cells + (cells + 1) * (k // cells)
    facets = np.column_stack([corner, corner + 1, corner + cells + 2, corner + cells + 1])
    return place(x.ravel(), y.ravel()), facets if up else facets[:, ::-1]


def pair(low, high, *, below=6, above=4):
    masters, master = grid(below, 0, low, up=True)
    slaves, slave = grid(above, len(masters), high, up=False)
    return np.vstack([masters, slaves]), master, slave


def flat(z):
    return lambda x, y: np.column_stack([x, y, np.full_like(x, z)])


def bumps():
    def height(x, y):
        return 0.3 * np.sin(0.6 * x + 0.2) * np.cos(0.5 * y)

    def high(x, y):
        x, y = 0.8 + 0.7 * x, 0.7 + 0.75 * y
        return np.column_stack([x, y, height(x, y) - 0.12 + 0.04 * x])

    return pair(lambda x, y: np.column_stack([x, y, height(x, y)]), high, below=7, above=5)


@pytest.mark.parametrize("element", ["diffuse", "node-to-facet"])
@pytest.mark.parametrize("degree", [2, 4])
def test_a_uniform_pressure_arrives_at_both_sides(element, degree):
    positions, master, slave = pair(flat(0.0), flat(-0.02))
    faces = dc.FaceInterface(dc.MasterSurface(positions, master), slave, positions, element=element, degree=degree)
    report = faces.refresh(positions)
    assert report.faces == 16 and report.paired == report.points
    contacts = faces.evaluate(PENALTY)
    assert contacts.is_contact.all() and np.allclose(contacts.pressure, 1.0, atol=1e-12)
    forces = faces.forces().reshape(-1, 3)
    areas = dc.tributary_areas(positions, slave) - dc.tributary_areas(positions, master)
    assert np.allclose(forces, np.outer(areas, [0.0, 0.0, 1.0]), atol=1e-12)


def test_points_integrate_to_what_nodes_carry():
    positions, master, slave = bumps()
    faces = dc.FaceInterface(dc.MasterSurface(positions, master), slave, positions)
    report = faces.refresh(positions)
    with pytest.raises(dc.InterfaceError) as refused:
        _ = faces.points
    assert refused.value.code == "not-evaluated"
    contacts, points = faces.evaluate(PENALTY), faces.points
    assert len(points.gap) == report.paired and set(points.face) <= set(range(len(slave)))
    found, carried = contacts.is_contact, points.area @ points.pressure
    assert carried > 1.0 and np.isclose(carried, contacts.force.sum(), rtol=1e-12)
    assert np.isclose(points.area @ points.gap, (contacts.area * contacts.gap)[found].sum(), rtol=1e-12)
    assert np.allclose(np.linalg.norm(points.normal, axis=1), 1.0) and not points.friction.any()
    # Within the sagitta of its face.
    middles = positions[slave[points.face]].mean(axis=1)
    assert np.linalg.norm(points.position - middles, axis=1).max() < 0.75


def test_points_may_have_pressures_of_their_own():
    # A cylinder that touches one wide face in its middle: on average it is open.
    positions, master, slave = pair(
        lambda x, y: np.column_stack([x, y, np.sqrt(900.0 - (x - 3.0) ** 2) - 30.0]), flat(-0.01), below=30, above=1
    )
    surface = dc.MasterSurface(positions, master)
    averages = dc.FaceInterface(surface, slave, positions)
    averages.refresh(positions)
    assert averages.evaluate(PENALTY).force.sum() == 0.0
    faces = dc.FaceInterface(surface, slave, positions, pressures="points")
    faces.refresh(positions)
    contacts, points = faces.evaluate(PENALTY), faces.points
    assert (contacts.gap > 0.0).all() and (contacts.pressure > 0.0).all()
    assert np.allclose(points.pressure, PENALTY * np.maximum(0.0, -points.gap), rtol=1e-12)
    expected = PENALTY * 4.0 / 3.0 * 0.01 * np.sqrt(60.0 * 0.01) * 6.0
    assert np.isclose(faces.forces().reshape(-1, 3)[len(positions) - 4 :, 2].sum(), expected, rtol=0.03)
    with pytest.raises(dc.InputError) as refused:
        dc.FaceInterface(surface, slave, positions, pressures="faces")
    assert refused.value.code == "invalid-option"


def quadratic_grid(cells, first, height, *, kind):
    """Nodes and faces of second order over [0, 6]²: a lattice of twice the cells, seen from above."""
    side = 2 * cells + 1
    x, y = np.meshgrid(np.linspace(0.0, 6.0, side), np.linspace(0.0, 6.0, side))
    k = np.arange(cells * cells)
    corner = first + 2 * (k % cells) + 2 * side * (k // cells)

    def at(i, j):
        return corner + i + side * j

    nine = np.column_stack([at(0, 0), at(2, 0), at(2, 2), at(0, 2), at(1, 0), at(2, 1), at(1, 2), at(0, 1), at(1, 1)])
    if kind == 6:
        lower = nine[:, [0, 1, 3, 4, 8, 7]]
        upper = nine[:, [2, 3, 1, 6, 8, 5]]
        faces = np.concatenate([lower, upper])
    else:
        faces = nine[:, :kind]
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, height)]), faces


def turned(faces):
    """The same faces seen from the other side."""
    order = {6: [0, 2, 1, 5, 4, 3], 8: [0, 3, 2, 1, 7, 6, 5, 4], 9: [0, 3, 2, 1, 7, 6, 5, 4, 8]}
    return faces[:, order[faces.shape[1]]]


@pytest.mark.parametrize(("below", "above"), [(6, 6), (8, 9), (9, 6), (6, 8)])
def test_faces_of_second_order_carry_by_their_own_functions(below, above):
    masters, master = quadratic_grid(3, 0, 0.0, kind=below)
    slaves, slave = quadratic_grid(2, len(masters), -0.02, kind=above)
    slave = turned(slave)
    # A lattice has nodes in the middle of cells that faces of 8 nodes do not use.
    used = np.zeros(len(masters) + len(slaves), dtype=bool)
    used[master.ravel()] = used[slave.ravel()] = True
    number = np.cumsum(used) - 1
    positions, master, slave = np.vstack([masters, slaves])[used], number[master], number[slave]
    flat = dc.flat_facets(slave)
    assert len(flat) == len(slave) * {6: 4, 8: 5, 9: 4}[above]
    surface = dc.MasterSurface(positions, dc.flat_facets(master))
    faces = dc.FaceInterface(surface, flat, positions, quadratic=[master, slave])
    faces.refresh(positions)
    contacts = faces.evaluate(PENALTY)
    assert np.allclose(contacts.pressure, 1.0, atol=1e-11)
    forces = faces.forces().reshape(-1, 3)[:, 2]
    # ∫ N dA over a cell: of corners, middles and centre.
    shares = {6: (0.0, 1 / 3, None), 8: (-1 / 12, 1 / 3, None), 9: (1 / 36, 1 / 9, 4 / 9)}
    expected = np.zeros(len(positions))
    for side, sign, cells in [(master, -1.0, 3), (slave, 1.0, 2)]:
        kind = side.shape[1]
        corner, middle, centre = shares[kind]
        area = (6.0 / cells) ** 2 * (0.5 if kind == 6 else 1.0)
        corners = 3 if kind == 6 else 4
        for column in range(kind):
            share = corner if column < corners else middle if column < 2 * corners else centre
            np.add.at(expected, side[:, column], sign * share * area)
    assert np.allclose(forces, expected, atol=1e-11)


def test_faces_of_second_order_are_checked():
    positions, faces = quadratic_grid(2, 0, 0.0, kind=9)
    with pytest.raises(dc.InputError, match="shape"):
        dc.flat_facets(faces[:, :7])
    with pytest.raises(dc.InputError, match="negative"):
        dc.flat_facets(-faces - 1)
    slaves, slave = quadratic_grid(1, len(positions), 1.0, kind=9)
    both, slave = np.vstack([positions, slaves]), turned(slave)
    surface = dc.MasterSurface(both, dc.flat_facets(faces))
    with pytest.raises(dc.InterfaceError):
        dc.FaceInterface(surface, dc.flat_facets(slave), both, quadratic=slave + 100)
    twice = slave.copy()
    twice[0, 8] = twice[0, 0]
    with pytest.raises(dc.InterfaceError):
        dc.FaceInterface(surface, dc.flat_facets(slave), both, quadratic=[twice])


def test_forces_balance_and_have_their_tangent():
    positions, master, slave = bumps()
    faces = dc.FaceInterface(dc.MasterSurface(positions, master), slave, positions)

    def at(x):
        faces.update(x)
        contacts = faces.evaluate(PENALTY)
        return contacts, faces.forces()

    contacts, forces = at(positions)
    assert 8 < (contacts.force > 0.0).sum() <= len(faces.slaves)
    rows = forces.reshape(-1, 3)
    size = np.abs(rows).sum()
    assert np.abs(rows.sum(axis=0)).max() < 1e-13 * size
    assert np.abs(np.cross(positions, rows).sum(axis=0)).max() < 1e-12 * size
    tangent = faces.tangent()
    v = np.random.default_rng(4).uniform(-1.0, 1.0, positions.size)
    for kind in ("exact", "gauss-newton"):
        product = faces.product(v, kind, out=np.ones(v.size)) - 1.0
        assert np.allclose(product, faces.tangent(kind) @ v, rtol=0.0, atol=1e-13 * np.abs(product).max())
    with pytest.raises(dc.InputError):
        faces.product(v, out=v)
    with pytest.raises(dc.AssemblyError):
        faces.product(v[1:])
    direction = np.random.default_rng(3).uniform(-1.0, 1.0, positions.shape)
    # Short enough for the faces to stay cut as they are.
    ahead, behind = (at(positions + step * direction)[1] for step in (1e-6, -1e-6))
    expected = -(ahead - behind) / 2e-6
    assert np.allclose(tangent @ direction.ravel(), expected, atol=1e-6 * np.abs(expected).max())


FRICTION = (0.3, 25.0)


def started(element="diffuse"):
    """Flat faces that have touched, and the positions after the slave has slid along x."""
    positions, master, slave = pair(flat(0.0), flat(-0.02))
    faces = dc.FaceInterface(dc.MasterSurface(positions, master), slave, positions, element=element)
    faces.refresh(positions)
    faces.accept(PENALTY, friction=FRICTION)
    moved = positions.copy()
    moved[faces.slaves, 0] += 0.05
    return faces, positions, moved


@pytest.mark.parametrize("element", ["diffuse", "node-to-facet"])
def test_friction_is_against_the_slip(element):
    faces, _, moved = started(element)
    faces.update(moved)
    assert not faces.evaluate(PENALTY).friction.any()
    contacts = faces.evaluate(PENALTY, friction=FRICTION)
    inside = np.abs(moved[faces.slaves, :2] - 3.0).max(axis=1) < 1.6
    assert np.allclose(contacts.friction[inside], [-0.3, 0.0, 0.0], atol=1e-12)
    assert np.allclose(contacts.slip[inside], 0.05) and set(contacts.friction_states) == {"slip"}
    forces = faces.forces().reshape(-1, 3)
    size = np.abs(forces).sum()
    assert np.abs(forces.sum(axis=0)).max() < 1e-13 * size
    assert np.abs(np.cross(moved, forces).sum(axis=0)).max() < 1e-12 * size
    report = faces.accept(PENALTY, friction=FRICTION)
    assert (report.stuck, report.sliding, report.unanchored) == (0, 25, 0)
    assert report.dissipated > 0.0
    with pytest.raises(dc.InterfaceError):
        faces.forces()


def test_the_tangent_with_friction_is_the_derivative():
    faces, positions, moved = started()
    moved = 0.6 * moved + 0.4 * positions
    moved[faces.slaves, 2] += 0.004 * moved[faces.slaves, 0]

    def at(x):
        faces.update(x)
        states = set(faces.evaluate(PENALTY, friction=FRICTION).friction_states)
        return states, faces.forces()

    faces.refresh(moved)
    assert at(moved)[0] >= {"slip"}
    tangent = faces.tangent()
    direction = np.random.default_rng(3).uniform(-1.0, 1.0, positions.shape)
    ahead, behind = (at(moved + step * direction)[1] for step in (1e-6, -1e-6))
    expected = -(ahead - behind) / 2e-6
    assert np.allclose(tangent @ direction.ravel(), expected, atol=1e-6 * np.abs(expected).max())


def test_a_shear_limit_is_kept():
    faces, _, moved = started()
    faces.update(moved)
    contacts = faces.evaluate(PENALTY, friction=(*FRICTION, 0.1))
    inside = np.abs(moved[faces.slaves, :2] - 3.0).max(axis=1) < 1.6
    assert np.allclose(contacts.friction[inside], [-0.1, 0.0, 0.0], atol=1e-12)
    with pytest.raises(dc.AssemblyError) as raised:
        faces.evaluate(PENALTY, friction=(*FRICTION, -0.1))
    assert raised.value.code == "invalid-shear-limit"


def test_a_history_goes_on_elsewhere():
    faces, positions, moved = started()
    faces.update(moved)
    faces.accept(PENALTY, friction=FRICTION)
    other, _, _ = started()
    other.history = faces.history
    forces = []
    for own in (faces, other):
        own.refresh(1.2 * moved - 0.2 * positions)
        own.evaluate(PENALTY, friction=FRICTION)
        forces.append(own.forces())
    assert np.array_equal(*forces)
    with pytest.raises(dc.InterfaceError) as raised:
        other.history = [0.5]
    assert raised.value.code == "invalid-history"
    other.history = []
    assert other.history.size == 0
    other.refresh(moved)
    with pytest.raises(dc.InterfaceError) as raised:
        other.evaluate(PENALTY, friction=FRICTION)
    assert raised.value.code == "no-slip"


def test_multipliers_take_the_penetration_away():
    positions, master, slave = pair(flat(0.0), flat(0.0))
    faces = dc.FaceInterface(dc.MasterSurface(positions, master), slave, positions)
    faces.refresh(positions)
    contacts = faces.evaluate(PENALTY, multipliers=np.full(25, 2.0))
    assert np.allclose(contacts.pressure, 2.0) and np.isclose(contacts.force.sum(), 72.0)


def test_equations_may_be_any():
    positions, master, slave = pair(flat(0.0), flat(-0.02))
    dofs = np.full((len(positions), 3), -1)
    dofs[49:, 2] = np.arange(25)
    faces = dc.FaceInterface(dc.MasterSurface(positions, master), slave, positions, dofs=dofs)
    faces.refresh(positions)
    faces.evaluate(PENALTY)
    assert faces.equations == 25 and np.isclose(faces.forces().sum(), 36.0)
    assert faces.tangent("gauss-newton").shape == (25, 25)


def test_refusals():
    positions, master, slave = pair(flat(0.0), flat(-0.02))
    surface = dc.MasterSurface(positions, master)
    with pytest.raises(dc.InputError, match="2 or 4"):
        dc.FaceInterface(surface, slave, positions, degree=3)
    with pytest.raises(dc.InputError, match="FaceInterface"):
        dc.FaceInterface(surface, slave, positions, degre=2)
    with pytest.raises(dc.InterfaceError):
        dc.FaceInterface(surface, master, positions)
    faces = dc.FaceInterface(surface, slave, positions)
    for call in (faces.forces, faces.tangent, lambda: faces.contacts):
        with pytest.raises(dc.InterfaceError) as raised:
            call()
        assert raised.value.code == "not-evaluated"
    with pytest.raises(dc.InterfaceError):
        faces.update(positions[1:])
    faces.refresh(positions)
    with pytest.raises(dc.InterfaceError):
        faces.evaluate(-1.0)
    faces.evaluate(PENALTY, mode="gradient")
    with pytest.raises(dc.AssemblyError) as raised:
        faces.tangent()
    assert raised.value.code == "not-derived"
    # A refused evaluation leaves the one before.
    before = faces.forces()
    with pytest.raises(dc.InterfaceError):
        faces.evaluate(PENALTY, multipliers=np.full(25, np.nan))
    np.testing.assert_array_equal(faces.forces(), before)
    with pytest.raises(TypeError):
        copy.copy(faces)
    assert repr(faces) == "<FaceInterface of 25 slaves, diffuse>"


def test_nodes_of_a_surface_touch_it():
    positions, master, slave = bumps()
    apart = positions.copy()
    apart[slave.min() :, 2] += 0.3
    surface = dc.MasterSurface(apart, np.vstack([master, slave]))
    for areas in (True, False):
        own = dc.ContactInterface.self_contact(surface, apart, areas=areas)
        assert np.array_equal(own.slaves, np.arange(len(positions)))
        own.refresh_pairing(positions)
        contacts = own.evaluate("hessian")
        assert (contacts.gap < 0.0).sum() > 10
        assert (contacts.area == 1.0).all() != areas
        forces = own.forces(PENALTY).reshape(-1, 3)
        assert abs(forces[: master.max() + 1, 2].sum()) > 1.0
        assert np.allclose(forces.sum(axis=0), 0.0, atol=1e-12)
        tangent = own.tangent(PENALTY)
        assert abs(tangent - tangent.T).max() < 1e-12 * abs(tangent).max()
    with pytest.raises(dc.InputError, match="MasterSurface"):
        dc.ContactInterface.self_contact(master, apart)
    with pytest.raises(dc.InputError, match="weigth"):
        dc.ContactInterface.self_contact(surface, apart, weigth="cubic")
    with pytest.raises(dc.InterfaceError) as error:
        own.window([[[-9.0] * 3, [9.0] * 3]], 0.0)
    assert error.value.code == "self-contact"


def test_a_surface_touches_itself():
    positions, master, slave = bumps()
    # Apart at first: a sheet right behind another would be the back of one body.
    apart = positions.copy()
    apart[slave.min() :, 2] += 0.3
    surface = dc.MasterSurface(apart, np.vstack([master, slave]))
    own = dc.FaceInterface(surface, None, apart)
    assert np.array_equal(own.slaves, np.arange(len(positions)))
    own.refresh(positions)
    contacts = own.evaluate(PENALTY)
    forces = own.forces().reshape(-1, 3)
    assert (contacts.pressure > 0.0).sum() > 10
    below = master.max() + 1
    assert abs(forces[:below, 2].sum()) > 1.0
    assert np.allclose(forces.sum(axis=0), 0.0, atol=1e-12)


def test_cliques_hold_all_that_the_tangent_couples():
    positions, master, slave = bumps()
    faces = dc.FaceInterface(dc.MasterSurface(positions, master), slave, positions)
    assert [len(array) for array in faces.cliques()] == [1, 0]
    faces.refresh(positions)
    offsets, nodes = faces.cliques()
    couples = np.zeros((len(positions), len(positions)), dtype=bool)
    for start, end in itertools.pairwise(offsets):
        clique = nodes[start:end]
        assert np.all(np.diff(clique) > 0)
        couples[np.ix_(clique, clique)] = True
    faces.evaluate(PENALTY)
    rows, columns = faces.tangent().nonzero()
    assert len(rows) > 1000 and couples[rows // 3, columns // 3].all()


def test_a_rank_may_have_no_faces():
    positions, master, _ = bumps()
    faces = dc.FaceInterface(dc.MasterSurface(positions, master), np.empty((0, 4), dtype=int), positions)
    assert faces.refresh(positions).points == len(faces.slaves) == 0
    assert len(faces.evaluate(PENALTY).gap) == len(faces.points.face) == 0
    assert not faces.forces().any() and faces.tangent().nnz == 0
