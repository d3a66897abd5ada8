"""Slaves that know a window of the surface have the results of the whole, bit for bit, or say that they cannot know."""

import pickle

import numpy as np
import pytest

import diffuse_contact as dc

LIMIT = 0.6


def height(x, y):
    return 0.4 * np.sin(np.pi / 6 * x) * np.cos(np.pi / 6 * y)


class Surface:
    """A wavy surface of irregular cells and slaves around it, also beyond its border and out of reach."""

    def __init__(self, cells_x=16, cells_y=9):
        random = np.random.default_rng(3)
        x, y = (a.ravel() for a in np.meshgrid(np.arange(cells_x + 1.0), np.arange(cells_y + 1.0)))
        inner = (x > 0) & (x < cells_x) & (y > 0) & (y < cells_y)
        x, y = (a + inner * random.uniform(-0.15, 0.15, len(x)) for a in (x, y))
        self.nodes = np.column_stack([x, y, height(x, y)])
        i, j = (a.ravel() for a in np.meshgrid(np.arange(cells_x), np.arange(cells_y)))
        corner = i + (cells_x + 1) * j
        self.facets = np.column_stack([corner, corner + 1, corner + cells_x + 2, corner + cells_x + 1])
        self.middles = self.nodes[self.facets].mean(axis=1)
        x, y = random.uniform(-0.5, [cells_x + 0.5, cells_y + 0.5], (120, 2)).T
        z = np.where(np.arange(120) % 17 == 0, 2.0, random.uniform(-0.2, 0.2, 120))
        self.slaves = np.column_stack([x, y, height(x, y) + z])

    def whole(self, **options):
        positions = np.vstack([self.nodes, self.slaves])
        master = dc.MasterSurface(positions, self.facets)
        slaves = np.arange(len(self.nodes), len(positions))
        interface = dc.ContactInterface(master, slaves, positions, **options)
        interface.refresh_pairing(positions)
        interface.evaluate()
        return interface


def partitions(points, parts):
    """Which part each point belongs to: strips, blocks, and by number."""
    strips = np.empty(len(points), dtype=int)
    strips[np.argsort(points[:, 0])] = np.arange(len(points)) * parts // len(points)
    halves = 1 if parts == 2 else 2
    blocks = np.clip(points[:, 0] / points[:, 0].max() * parts / halves, 0, parts / halves - 1).astype(int)
    blocks = halves * blocks + np.clip(points[:, 1] / points[:, 1].max() * halves, 0, halves - 1).astype(int)
    return {"strips": strips, "blocks": blocks, "by number": np.arange(len(points)) % parts}


def in_window(window, nodes, slaves, **options):
    """An interface of slaves in a window that has been sent."""
    window = pickle.loads(pickle.dumps(window))
    positions = np.vstack([nodes[window.nodes], slaves])
    own = np.arange(len(window.nodes), len(positions))
    interface = dc.ContactInterface.in_window(window, own, positions, **options)
    assert interface.is_in_window
    interface.refresh_pairing(positions)
    interface.evaluate()
    return interface


def compare(whole, part, places, numbers):
    """Returns how many slaves cannot know; all else is compared bit for bit."""
    beyond = 0
    for k, place in enumerate(places):
        expected, found = whole.contact(int(place)), part.contact(k)
        if found.outcome == "beyond-window":
            assert found.gap is None and found.gradient is None
            beyond += 1
            continue
        assert found.outcome == expected.outcome
        if found.outcome != "contact":
            continue
        assert np.array_equal(numbers[found.masters], expected.masters)
        assert found.gap == expected.gap
        for name in ("foot", "normal", "gradient", "hessian"):
            assert np.array_equal(getattr(found, name), getattr(expected, name)), name
    return beyond


@pytest.mark.parametrize("parts", [2, 4, 8])
def test_any_partition_has_the_bits_of_the_whole(parts):
    surface = Surface()
    whole = surface.whole(distance_limit=LIMIT)
    assert not whole.is_in_window
    assert {"contact", "too-far", "beyond-border"} <= set(whole.contacts.outcomes)
    for name, part in partitions(surface.slaves, parts).items():
        for rank in range(parts):
            places = np.flatnonzero(part == rank)
            boxes = dc.boxes_around(surface.slaves[places], 1.01 * LIMIT, 6)
            assert boxes.shape[1:] == (2, 3) and 1 <= len(boxes) <= 6
            window = whole.window(boxes, 0.0)
            assert np.array_equal(window.boxes, boxes) and window.skin == 0.0
            assert np.array_equal(window.first_positions, surface.nodes[window.nodes])
            if parts == 8 and name == "strips" and rank == 0:
                assert len(window.nodes) < 0.6 * len(surface.nodes)
            found = in_window(window, surface.nodes, surface.slaves[places], distance_limit=LIMIT)
            assert compare(whole, found, places, window.nodes) == 0


class Part:
    """The facets of a rank and all those that meet a box around them, with orders of its own."""

    def __init__(self, surface, own, width):
        corners = surface.nodes[surface.facets[own]].reshape(-1, 3)
        self.known = np.array([corners.min(axis=0) - width, corners.max(axis=0) + width])
        low, high = (getattr(surface.nodes[surface.facets], which)(axis=1) for which in ("min", "max"))
        meets = ((low <= self.known[1]) & (self.known[0] <= high)).all(axis=1)
        self.facets = np.flatnonzero(meets)[::-1]
        self.nodes, places = np.unique(surface.facets[self.facets], return_inverse=True)
        self.corners = places.reshape(-1, 4)
        self.positions = surface.nodes[self.nodes]
        self.owned = np.isin(self.facets, own)
        self.extents = dc.Extents.of(self.positions, self.corners[self.owned])

    def make(self, extents, **options):
        return dc.SurfacePart(
            self.positions,
            self.corners,
            node_numbers=self.nodes,
            facet_numbers=self.facets,
            owned=self.owned,
            known=self.known,
            extents=extents,
            **options,
        )

    def is_beside(self, other):
        return (self.known[0] <= other.known[1]).all() and (other.known[0] <= self.known[1]).all()


@pytest.mark.parametrize("symmetry", [(), [([0.0, 0.0, 0.0], [0.0, 1.0, 0.0])]])
def test_parts_make_the_window_of_the_whole(symmetry):
    surface = Surface(40, 5)
    if symmetry:
        # On the model's side of the plane.
        surface.slaves[:, 1] = np.abs(surface.slaves[:, 1])
    whole = surface.whole(symmetry=symmetry)
    boxes = dc.boxes_around(surface.nodes[[0, 130, 200]], 0.7, 3)
    expected = whole.window(boxes, 0.05)
    for part in partitions(surface.middles, 4).values():
        ranks = [Part(surface, np.flatnonzero(part == rank), 16.0) for rank in range(4)]
        extents = ranks[0].extents
        for rank in ranks[1:]:
            extents = rank.extents.joined(extents)
        made = [rank.make(extents, symmetry=symmetry) for rank in ranks]
        with pytest.raises(dc.InterfaceError) as error:
            made[0].window(ranks[0].positions, boxes, 0.05)
        assert error.value.code == "invalid-window"
        for is_last in (False, True):
            demands = pickle.loads(pickle.dumps([own.demands for own in made]))
            for own, rank in zip(made, ranks, strict=True):
                others = [d for d, other in zip(demands, ranks, strict=True) if rank.is_beside(other)]
                assert own.settle(others) is is_last
        windows = [own.window(rank.positions, boxes, 0.05) for own, rank in zip(made, ranks, strict=True)]
        assert dc.Window.joined(windows) == expected
        assert dc.Window.joined(windows[:1]) != expected


def test_a_slave_that_cannot_know_has_no_number():
    surface = Surface()
    whole = surface.whole()
    slaves = np.arange(40)
    window = whole.window(dc.boxes_around(surface.slaves[slaves], 0.15), 0.0)
    found = in_window(window, surface.nodes, surface.slaves[slaves])
    assert 0 < compare(whole, found, slaves, window.nodes) < 40
    outcomes = np.array(found.contacts.outcomes)
    assert (outcomes == "beyond-window").any() and (outcomes == "contact").any()
    assert np.isnan(found.contacts.gap[outcomes == "beyond-window"]).all()
    # A window is good while nothing of it has moved by more than its skin.
    window = whole.window(dc.boxes_around(surface.slaves[slaves], 3.0), 0.1)
    numbers = window.nodes
    for moved, expected in ((0.099, False), (0.101, True)):
        nodes = surface.nodes + [0.0, 0.0, moved]
        found = in_window(window, surface.nodes, surface.slaves[slaves])
        positions = np.vstack([nodes[numbers], surface.slaves[slaves]])
        found.refresh_pairing(positions)
        found.evaluate()
        assert ("beyond-window" in found.contacts.outcomes) == expected


def test_refusals():
    surface = Surface(20, 5)
    whole = surface.whole()
    window = whole.window(dc.boxes_around(surface.slaves[:9], 1.0), 0.0)

    def code(call, *arguments, **options):
        with pytest.raises(dc.DiffuseContactError) as error:
            call(*arguments, **options)
        return error.value.code

    positions = np.vstack([surface.nodes[window.nodes], surface.slaves[:9]])
    own = np.arange(len(window.nodes), len(positions))
    make = dc.ContactInterface.in_window
    assert code(make, window, own, positions, feature_angle=30.0) == "other-than-window"
    assert code(make, window, own, positions, rule="nearest") == "window-needs-domains"
    assert code(make, window, own, positions[: len(window.nodes) - 1]) == "wrong-number-of-positions"
    assert code(make, "window", own, positions) == "wrong-type"
    assert code(make, window, own, positions, penalty=1.0) == "unknown-option"
    assert code(make(window, own, positions).window, [], 0.0) == "in-window"
    assert code(surface.whole(element="node-to-facet").window, [], 0.0) == "window-needs-domains"
    assert code(whole.window, [[[0.0, 0.0, 0.0], [1.0, -1.0, 1.0]]], 0.0) == "invalid-box"
    assert code(whole.window, [], -1.0) == "invalid-box"
    assert code(dc.Window.joined, []) == "invalid-window"
    with pytest.raises(dc.InterfaceError, match="no window to join"):
        dc.Window.joined([])
    with pytest.raises(dc.InterfaceError, match=f"but the window has {len(window.nodes)} nodes"):
        make(window, own, positions[: len(window.nodes) - 1])
    assert code(dc.Window.joined, [window, whole.window([], 0.0)]) == "different-windows"
    integers, reals = window.numbers
    assert dc.Window(integers, reals) == window
    assert code(dc.Window, integers[1:], reals) == "invalid-window"
    assert code(dc.Window, integers, reals[1:]) == "invalid-window"
    # Lists are searched, so that they are ascending.
    wrong = integers.copy()
    wrong[-1] = wrong[-2]
    assert code(dc.Window, wrong, reals) == "invalid-window"
    for reach in (-0.1, np.nan, np.inf):
        assert code(dc.boxes_around, surface.slaves, reach) == "invalid-option"
    narrow = Part(surface, np.array([45, 46]), 1.5)
    assert code(narrow.make, narrow.extents) == "part-too-narrow"
    nothing = dc.Extents.of(np.empty((0, 3)), np.empty((0, 4), dtype=int))
    nan = dc.Extents(narrow.extents.low, (np.nan,) * 3, narrow.extents.facet)
    for extents in (nothing, nan, dc.Extents(narrow.extents.low, narrow.extents.high, 0.1)):
        assert code(narrow.make, extents) == "invalid-extents"
    wide = Part(surface, np.arange(100), 16.0)
    across = [(surface.nodes.mean(axis=0), [1.0, 0.0, 0.0])]
    assert code(wide.make, wide.extents, symmetry=across) == "cut-by-symmetry"
    part = wide.make(wide.extents)
    demands = part.demands
    crowded = demands.crowded.astype(int)
    crowded[0] = 256
    wrapped = dc.PartDemands(demands.nodes, demands.factors, crowded, demands.facets, demands.bases)
    assert code(part.settle, [wrapped]) == "invalid-option"
    narrow.facets = -1 - narrow.facets
    assert code(narrow.make, narrow.extents) == "negative-index"


def test_friction_goes_with_slaves_to_other_parts():
    surface = Surface()
    penalty, friction, steps = 1e3, (0.3, 500.0), [[0.35, 0.1, 0.0], [0.7, 0.2, 0.0]]
    start = surface.slaves - [0.0, 0.0, 0.2]
    whole = surface.whole(distance_limit=1.2)

    def forces(interface, nodes, slaves):
        positions = np.vstack([nodes, slaves])
        interface.refresh_pairing(positions)
        interface.evaluate()
        return interface.forces(penalty, friction=friction).reshape(-1, 3)[len(nodes) :]

    def accepted(interface, nodes, slaves):
        interface.refresh_pairing(np.vstack([nodes, slaves]))
        try:
            interface.accept(penalty, friction=friction)
        except dc.InterfaceError as error:
            assert error.code == "no-friction-kernels"
            pytest.skip("built without friction")

    accepted(whole, surface.nodes, start)
    before, histories = start, dc.split_history(whole.history)
    for step, at in enumerate(steps):
        slaves = start + at
        expected = forces(whole, surface.nodes, slaves)
        part = partitions(slaves - slaves.min(axis=0), 4)[("strips", "blocks")[step]]
        kept = [None] * len(slaves)
        for rank in range(4):
            places = np.flatnonzero(part == rank)
            # Boxes hold the anchors, which lie where slaves were.
            boxes = dc.boxes_around(np.vstack([slaves[places], before[places]]), 1.5)
            window = whole.window(boxes, 0.0)
            nodes = surface.nodes[window.nodes]
            positions = np.vstack([nodes, slaves[places]])
            own = np.arange(len(nodes), len(positions))
            found = dc.ContactInterface.in_window(window, own, positions, distance_limit=1.2)
            found.history = np.concatenate([histories[place] for place in places])
            assert np.array_equal(forces(found, nodes, slaves[places]), expected[places])
            accepted(found, nodes, slaves[places])
            for place, history in zip(places, dc.split_history(found.history), strict=True):
                kept[place] = history
        accepted(whole, surface.nodes, slaves)
        assert np.array_equal(np.concatenate(kept), whole.history)
        assert (np.abs(expected[:, :2]) > 0).any()
        before, histories = slaves, kept


def test_histories_go_slave_by_slave():
    # One without an anchor, one of two nodes.
    parts = [[-1.0], [2.0, 0.1, 7.0, -1.0, 0.25, 9.0, -1.0, 0.75], [-1.0]]
    found = dc.split_history(np.concatenate(parts))
    assert [part.tolist() for part in found] == parts
    assert dc.split_history([]) == []
    with pytest.raises(dc.InterfaceError) as error:
        dc.split_history([2.0, 0.1])
    assert error.value.code == "invalid-history"


class Pair:
    """A block's wavy underside just in the surface, both as interfaces without slaves, to cut windows from."""

    def __init__(self):
        self.surface = Surface(16, 9)
        x, y = (a.ravel() for a in np.meshgrid(np.linspace(0.8, 15.0, 20), np.linspace(0.9, 8.2, 11)))
        self.offset = len(self.surface.nodes)
        self.positions = np.vstack([self.surface.nodes, np.column_stack([x, y, height(x, y) - 0.03])])
        i, j = (a.ravel() for a in np.meshgrid(np.arange(19), np.arange(10)))
        corner = self.offset + i + 20 * j
        self.faces = np.column_stack([corner, corner + 20, corner + 21, corner + 1])
        self.sides = [
            dc.ContactInterface(dc.MasterSurface(self.positions, facets), [], self.positions, distance_limit=LIMIT)
            for facets in (self.surface.facets, self.faces)
        ]

    def whole(self):
        master = dc.MasterSurface(self.positions, self.surface.facets)
        return dc.FaceInterface(master, self.faces, self.positions, distance_limit=LIMIT)

    def windows(self, places, reach):
        """Windows of both sides around nodes, sent, with the numbers of their nodes."""
        around = self.positions[places]
        boxes = [dc.boxes_around(around, width, 4) for width in (reach, 1.2)]
        windows = [side.window(box, 0.0) for side, box in zip(self.sides, boxes, strict=True)]
        windows = [pickle.loads(pickle.dumps(window)) for window in windows]
        return windows, np.concatenate([window.nodes for window in windows])


@pytest.mark.parametrize("reach", [3.0, 0.8])
@pytest.mark.parametrize("parts", [2, 4])
def test_faces_in_windows_have_the_bits_of_the_whole(parts, reach):
    pair = Pair()
    whole = pair.whole()
    assert not whole.is_in_window
    whole.refresh(pair.positions)
    expected = whole.evaluate(1e2)
    assert (expected.pressure > 0.0).sum() > 150
    place = {node: k for k, node in enumerate(whole.slaves)}
    known = beyond = 0
    for part in partitions(pair.positions[whole.slaves], parts).values():
        for rank in range(parts):
            own = whole.slaves[part == rank]
            windows, numbers = pair.windows(own, reach)
            positions = pair.positions[numbers]
            faces = dc.FaceInterface.in_window(*windows, positions, distance_limit=LIMIT)
            assert faces.is_in_window
            faces.refresh(positions)
            found = faces.evaluate(1e2)
            assert np.isin(own, numbers[faces.slaves]).all()
            for k, number in enumerate(numbers[faces.slaves]):
                if found.outcomes[k] == "beyond-window":
                    assert found.pressure[k] == found.area[k] == 0.0 and np.isnan(found.gap[k])
                    assert number not in own or reach < 1.0
                    beyond += 1
                    continue
                for name in ("gap", "area", "pressure", "normal"):
                    of_part, of_whole = getattr(found, name)[k], getattr(expected, name)[place[number]]
                    assert np.array_equal(of_part, of_whole, equal_nan=True), name
                known += number in own
    own = 3 * len(whole.slaves)
    assert beyond > 0 and (known == own if reach > 1.0 else 0 < known < own)


def test_friction_over_faces_goes_with_nodes_to_other_windows():
    pair = Pair()
    law = {"penalty": 1e2, "friction": (0.3, 30.0)}
    whole = pair.whole()
    steps = [pair.positions.copy() for _ in range(3)]
    for k, step in enumerate(steps):
        step[pair.offset :] += k * np.array([0.02, 0.01, -0.005])
    expected, after = [], []
    for step in steps:
        whole.refresh(step)
        expected.append(whole.evaluate(**law, mode="value") if after else None)
        whole.accept(**law)
        parts = dc.split_history(whole.history)
        after.append({node: np.concatenate(parts[2 * k : 2 * k + 2]) for k, node in enumerate(whole.slaves)})
    assert {"stick", "slip"} <= set(expected[2].friction_states)
    rows = {node: k for k, node in enumerate(whole.slaves)}
    for which, parts in enumerate((2, 4)):
        # Windows of other nodes in each step.
        for part in list(partitions(pair.positions[whole.slaves], parts).values())[which : which + 1]:
            for rank in range(parts):
                own = whole.slaves[part == rank]
                windows, numbers = pair.windows(own, 3.0)
                faces = dc.FaceInterface.in_window(*windows, pair.positions[numbers], distance_limit=LIMIT)
                own = np.flatnonzero(np.isin(numbers[faces.slaves], own))
                history = [np.array([-1.0, -1.0]) for _ in faces.slaves]
                for k in own:
                    history[k] = after[which][numbers[faces.slaves[k]]]
                faces.history = np.concatenate(history)
                faces.refresh(steps[which + 1][numbers])
                found = faces.evaluate(**law, mode="value")
                place = [rows[number] for number in numbers[faces.slaves[own]]]
                for name in ("gap", "pressure", "friction", "slip"):
                    of_part, of_whole = (getattr(of, name) for of in (found, expected[which + 1]))
                    assert np.array_equal(of_part[own], of_whole[place], equal_nan=True), name
                faces.accept(**law)
                kept = dc.split_history(faces.history)
                for k in own:
                    exact = after[which + 1][numbers[faces.slaves[k]]]
                    assert np.array_equal(np.concatenate(kept[2 * k : 2 * k + 2]), exact)
    history[own[0]] = np.array([1.0, 0.0, 1e6, -1.0, 1.0] * 2)
    foreign = np.concatenate(history)
    with pytest.raises(dc.InterfaceError) as error:
        faces.history = foreign
    assert error.value.code == "foreign-carrier"


def quadrilaterals(first, cells, width):
    """Faces of 9 nodes over a lattice with so many nodes in a row."""
    i, j = (a.ravel() for a in np.meshgrid(*(2 * np.arange(count) for count in cells)))
    corner = first + i + width * j
    steps = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]
    return np.column_stack([corner + a + width * b for a, b in steps])


def test_faces_of_second_order_in_windows_have_the_rows_of_the_whole():
    pair = Pair()
    # The lattice's last cells stay faces of first order, where it has an odd number.
    master = quadrilaterals(0, (8, 4), 17)
    slave = quadrilaterals(pair.offset, (9, 5), 20)[:, [0, 3, 2, 1, 7, 6, 5, 4, 8]]
    surface = dc.MasterSurface(pair.positions, pair.surface.facets)
    whole = dc.FaceInterface(surface, pair.faces, pair.positions, distance_limit=LIMIT, quadratic=[master, slave])
    whole.refresh(pair.positions)
    expected = whole.evaluate(1e2)
    forces = whole.forces().reshape(-1, 3)
    flat = pair.whole()
    flat.refresh(pair.positions)
    flat.evaluate(1e2)
    assert np.abs(flat.forces().reshape(-1, 3) - forces).max() > 0.1 * np.abs(forces).max()
    place = {node: k for k, node in enumerate(whole.slaves)}
    x = pair.positions[whole.slaves]
    windows, numbers = pair.windows(whole.slaves[x[:, 0] < 9.0], 3.0)
    positions = pair.positions[numbers]
    of_second = {"quadratic_master": master, "quadratic_slave": [slave]}
    faces = dc.FaceInterface.in_window(*windows, positions, distance_limit=LIMIT, **of_second)
    faces.refresh(positions)
    found = faces.evaluate(1e2)
    known = [k for k, node in enumerate(faces.slaves) if pair.positions[numbers[node], 0] < 9.0]
    assert len(known) > 100
    for k in known:
        number = numbers[faces.slaves[k]]
        assert found.outcomes[k] == expected.outcomes[place[number]] != "beyond-window"
        assert found.pressure[k] == expected.pressure[place[number]]
    rows = faces.slaves[[k for k in known if pair.positions[numbers[faces.slaves[k]], 0] < 7.0]]
    own = faces.forces().reshape(-1, 3)[rows]
    np.testing.assert_allclose(own, forces[numbers[rows]], atol=1e-13 * np.abs(forces).max())
    with pytest.raises(dc.InterfaceError) as error:
        dc.FaceInterface.in_window(*windows, positions, distance_limit=LIMIT, quadratic_slave=slave[:, [0] * 9])
    assert error.value.code == "repeated-node"


def test_faces_in_windows_refuse_what_takes_the_whole():
    pair = Pair()
    windows, numbers = pair.windows(np.arange(pair.offset, pair.offset + 50), 3.0)
    positions = pair.positions[numbers]

    def code(call, *arguments, **options):
        with pytest.raises(dc.DiffuseContactError) as error:
            call(*arguments, **options)
        return error.value.code

    make = dc.FaceInterface.in_window
    assert code(make, *windows, positions) == "invalid-option"
    assert code(make, *windows, positions, distance_limit=LIMIT, weight="wendland-c2") == "other-than-window"
    assert code(make, *windows, positions[1:], distance_limit=LIMIT) == "wrong-number-of-positions"
    assert code(make, windows[0], "window", positions, distance_limit=LIMIT) == "wrong-type"
    assert code(make, *windows, positions, distance_limit=LIMIT, degree=3) == "invalid-option"
    assert code(make, *windows, positions, distance_limit=LIMIT, penalty=1.0) == "unknown-option"
    faces = make(*windows, positions, distance_limit=LIMIT)
    faces.refresh(positions)
    dofs = np.arange(positions.size).reshape(-1, 3)[::-1]
    numbered = make(*windows, positions, distance_limit=LIMIT, dofs=dofs)
    for interface in (faces, numbered):
        interface.refresh(positions)
        interface.evaluate(1e2)
    np.testing.assert_array_equal(numbered.forces()[dofs], faces.forces().reshape(-1, 3))


def test_extents_are_values():
    one = dc.Extents.of([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    assert one.joined(one) == one and hash(one.joined(one)) == hash(one)
    assert one == dc.Extents((0.0, 0.0, 0.0), (1.0, 1.0, 0.0), np.sqrt(2.0))
    for nodes, corners in ([[[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]]], [np.eye(3), [[0, 1, 3]]]):
        with pytest.raises(dc.SurfaceError):
            dc.Extents.of(nodes, corners)
