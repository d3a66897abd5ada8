"""Laws by table, coefficients by pressure and rate, augmented friction."""

import copy
import pickle

import numpy as np
import pytest

import diffuse_contact as dc

STIFFNESS = 60.0
DURATION = 0.5
#: Ten times as stiff from 0.02 on: p(−0.02) = 1.
TABLE = dc.TabulatedPressure([-0.1, -0.02, 0.0], [41.0, 1.0, 0.0])


def grid(cells, first, low, high, z, *, up):
    x, y = np.meshgrid(np.linspace(low, high, cells + 1), np.linspace(low, high, cells + 1))
    k = np.arange(cells * cells)
    corner = first + k % cells + (cells + 1) * (k // cells)
    facets = np.column_stack([corner, corner + 1, corner + cells + 2, corner + cells + 1])
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, z)]), facets if up else facets[:, ::-1]


def block(law, step, *, depth=0.02):
    """A flat block on a larger plate, accepted and moved along x; what it gives, where."""
    (plate, master), (upper, slave) = grid(6, 0, 0.0, 6.0, 0.0, up=True), grid(4, 49, 1.5, 4.5, -depth, up=False)
    positions = np.vstack([plate, upper])
    faces = dc.FaceInterface(dc.MasterSurface(positions, master), slave, positions)
    faces.refresh(positions)
    faces.accept(50.0, **law)
    moved = positions.copy()
    moved[49:, 0] += step
    faces.refresh(moved)
    return faces, moved


def derivative_error(faces, positions, law, step=1e-6):
    """Of K against central differences of R along a direction, over the largest."""
    direction = np.random.default_rng(3).uniform(-1.0, 1.0, positions.shape)

    def at(x):
        faces.update(x)
        faces.evaluate(50.0, **law)
        return faces.forces()

    slope = -(at(positions + step * direction) - at(positions - step * direction)) / (2.0 * step)
    at(positions)
    return np.abs(faces.tangent() @ direction.ravel() - slope).max() / np.abs(slope).max()


def test_a_table_is_the_pressure_over_faces():
    for depth in (0.01, 0.05):
        faces, positions = block({"friction": 0.0, "normal": TABLE}, 0.0, depth=depth)
        contacts = faces.evaluate(50.0, normal=TABLE)
        expected = np.interp(-depth, TABLE.gaps, TABLE.pressures)
        np.testing.assert_allclose(contacts.pressure, expected, rtol=1e-12)
        assert derivative_error(faces, positions, {"normal": TABLE}) < 1e-6


def test_a_table_is_the_force_of_nodes(scene):
    interface = scene.evaluated()
    gap = interface.contacts.gap
    forces = interface.normal_forces(50.0, normal=TABLE)
    np.testing.assert_allclose(forces, np.interp(gap, TABLE.gaps, TABLE.pressures), rtol=1e-12)
    # The penalty's law is a table, too.
    line = dc.TabulatedPressure([-1.0, 1.0], [50.0, -50.0])
    for ask in (interface.forces, interface.tangent_values, interface.pressures):
        np.testing.assert_allclose(ask(50.0, normal=line), ask(50.0), rtol=0, atol=1e-12)
    rows, columns, values = interface.triplets(1.0, normal=line)
    assert np.isclose(values.sum(), interface.triplets(50.0)[2].sum()) and len(rows) == len(columns)
    v = np.arange(255.0)
    tangent = interface.tangent(1.0, normal=TABLE)
    np.testing.assert_allclose(interface.operator(1.0, normal=TABLE) @ v, tangent @ v, rtol=0, atol=1e-7)
    matrix = tangent.copy()
    interface.csr_map(matrix).add(matrix.data, 1.0, normal=TABLE)
    np.testing.assert_allclose(matrix.data, 2.0 * tangent.data, rtol=0, atol=1e-12)
    with pytest.raises(dc.AssemblyError) as caught:
        interface.forces(50.0, normal=TABLE, multipliers=np.zeros(4))
    assert caught.value.code == "multipliers-of-own-law"


COEFFICIENTS = [
    (dc.DecayingCoefficient(0.5, 0.2, 2.0), lambda p, v: 0.2 + 0.3 * np.exp(-2.0 * v)),
    (
        dc.TabulatedCoefficient([0.0, 4.0], [0.0, 1.0], [[0.5, 0.3], [0.3, 0.1]]),
        lambda p, v: 0.5 - 0.05 * p - 0.2 * v,
    ),
]


@pytest.mark.parametrize(("coefficient", "value"), COEFFICIENTS)
def test_a_coefficient_by_pressure_and_rate_is_that_of_what_slides(coefficient, value):
    friction = dc.Coulomb(coefficient, STIFFNESS, duration=DURATION)
    law = {"friction": friction}
    # μ p is at least 0.2: the first sticks, the second slides.
    for step, state in ((1e-3, "stick"), (0.05, "slip")):
        faces, positions = block(law, step)
        contacts = faces.evaluate(50.0, **law)
        assert set(contacts.friction_states) == {state}
        traction = np.linalg.norm(contacts.friction, axis=1)
        if state == "stick":
            np.testing.assert_allclose(traction, STIFFNESS * step, rtol=1e-10)
        else:
            rate = (step - traction / STIFFNESS) / DURATION
            assert np.all(rate > 0.05)
            np.testing.assert_allclose(traction, value(1.0, rate) * 1.0, rtol=1e-9)
        assert derivative_error(faces, positions, law) < 1e-6
    report = faces.accept(50.0, **law)
    assert report.sliding == 25 and report.dissipated > 0.0
    # A constant one is that number, bit for bit.
    numbers, same = (block({"friction": f}, 0.05)[0] for f in ((0.3, 60.0, 0.2), dc.Coulomb(0.3, 60.0, 0.2)))
    one, other = (
        numbers.evaluate(50.0, friction=(0.3, 60.0, 0.2)),
        same.evaluate(50.0, friction=dc.Coulomb(0.3, 60.0, 0.2)),
    )
    np.testing.assert_array_equal(one.friction, other.friction)


def test_rounds_of_augmentation_are_tried_accepted_and_forgotten():
    law = {"friction": dc.Coulomb(0.3, STIFFNESS, augmented=True)}
    faces, positions = block(law, 1e-3)
    first = faces.evaluate(50.0, **law)
    np.testing.assert_allclose(faces.slip_errors(50.0, **law), 1e-3, rtol=1e-9)
    history = faces.history
    faces.augment(50.0, **law, moves=np.arange(25) % 2 == 0)
    with pytest.raises(dc.InterfaceError) as caught:
        faces.forces()
    assert caught.value.code == "not-evaluated"
    half = faces.evaluate(50.0, **law)
    # The traction of before is the multiplier: at the same positions it is there twice.
    np.testing.assert_allclose(half.friction[::2], 2.0 * first.friction[::2], rtol=0, atol=1e-12)
    np.testing.assert_allclose(half.friction[1::2], first.friction[1::2], rtol=0, atol=1e-12)
    # Another interface goes on from the round.
    other, _ = block(law, 1e-3)
    other.history = faces.augmented_history
    np.testing.assert_array_equal(faces.history, history)
    other.refresh(positions)
    np.testing.assert_array_equal(other.evaluate(50.0, **law).friction, half.friction)
    faces.roll_back()
    faces.refresh(positions)
    np.testing.assert_array_equal(faces.evaluate(50.0, **law).friction, first.friction)
    np.testing.assert_array_equal(faces.history, history)
    # Where the block is back, the multiplier alone is left, and nothing is wrong any more.
    faces.augment(50.0, **law)
    back = positions.copy()
    back[49:, 0] -= 1e-3
    faces.refresh(back)
    np.testing.assert_allclose(faces.evaluate(50.0, **law).friction, first.friction, rtol=0, atol=1e-12)
    assert np.abs(faces.slip_errors(50.0, **law)).max() < 1e-12
    assert faces.accept(50.0, **law).stuck == 25
    for wrong, error, code in (
        ({"friction": 0.3}, dc.InterfaceError, "no-augmentation"),
        ({**law, "moves": np.array([True])}, dc.InputError, "wrong-shape"),
        ({**law, "moves": np.zeros(25)}, dc.InputError, "wrong-type"),
    ):
        with pytest.raises(error) as caught:
            faces.augment(50.0, **wrong)
        assert caught.value.code == code
    # Without friction there is nothing to take over, and what slid freely is no slip of the next increment.
    none = {"friction": 0.0}
    faces.augment(50.0, **none)
    assert (faces.slip_errors(50.0, **none) == 0.0).all()
    faces.refresh(positions)
    assert faces.accept(50.0, **none) == (0, 0, 0, 0, 0.0)
    faces.refresh(positions)
    assert np.abs(faces.evaluate(50.0, **law).slip).max() < 1e-12


def test_nodes_are_augmented(scene):
    law = {"friction": dc.Coulomb(0.4, 500.0, augmented=True)}
    interface = scene.interface()
    interface.refresh_pairing(scene.positions)
    try:
        interface.accept(1e3, **law)
    except dc.InterfaceError as error:
        assert error.code == "no-friction-kernels"
        pytest.skip("built without friction")
    moved = scene.positions.copy()
    moved[81:, 0] += 1e-3
    interface.refresh_pairing(moved)
    interface.evaluate()

    def traction():
        interface.evaluate()
        return (interface.forces(1e3, **law) - interface.forces(1e3)).reshape(-1, 3)[81:, 0]

    first = traction()
    np.testing.assert_allclose(interface.slip_errors(1e3, **law), 1e-3, rtol=0.02)
    interface.augment(1e3, **law)
    np.testing.assert_allclose(traction(), 2.0 * first, rtol=0.02)
    assert not np.array_equal(interface.augmented_history, interface.history)
    interface.roll_back()
    np.testing.assert_array_equal(interface.augmented_history, interface.history)
    interface.refresh_pairing(moved)
    np.testing.assert_array_equal(traction(), first)


def test_a_table_of_one_coefficient_is_that_coefficient():
    coefficient = dc.TabulatedCoefficient([1.0], [0.0], [[0.3]])
    law = {"friction": dc.Coulomb(coefficient, STIFFNESS, duration=DURATION)}
    faces, _ = block(law, 0.5)
    contacts = faces.evaluate(50.0, **law)
    assert "slip" in contacts.friction_states
    slides = np.array(contacts.friction_states) == "slip"
    ratio = np.linalg.norm(contacts.friction[slides], axis=1) / contacts.pressure[slides]
    np.testing.assert_allclose(ratio, 0.3, rtol=1e-12)


def test_what_is_no_law_is_refused():
    for make, code in (
        (lambda: dc.TabulatedPressure([0.0], [1.0]), "invalid-table"),
        (lambda: dc.TabulatedPressure([0.0, 0.0], [1.0, 0.0]), "invalid-table"),
        (lambda: dc.TabulatedPressure([0.0, 1.0], [1.0, np.nan]), "invalid-table"),
        (lambda: dc.Coulomb(-0.1), "invalid-friction-coefficient"),
        (lambda: dc.Coulomb(0.1, 0.0), "invalid-friction-stiffness"),
        (lambda: dc.Coulomb(0.1, shear_limit=-1.0), "invalid-shear-limit"),
        (lambda: dc.Coulomb(dc.DecayingCoefficient(0.3, 0.2, 1.0)), "invalid-duration"),
        (lambda: dc.Coulomb(dc.DecayingCoefficient(0.3, 0.2, -1.0), duration=1.0), "invalid-decay"),
        (
            lambda: dc.Coulomb(dc.TabulatedCoefficient([1.0], [0.0], [[-0.1]]), duration=1.0),
            "invalid-friction-coefficient",
        ),
        (lambda: dc.Coulomb(dc.TabulatedCoefficient([2.0, 1.0], [0.0], [[0.1], [0.1]]), duration=1.0), "invalid-table"),
    ):
        with pytest.raises(dc.AssemblyError) as caught:
            make()
        assert caught.value.code == code
    with pytest.raises(dc.AssemblyError, match="duration is missing"):
        dc.Coulomb(dc.DecayingCoefficient(0.3, 0.2, 1.0))
    for make in (
        lambda: dc.TabulatedCoefficient([1.0, 2.0], [0.0], [[0.1]]),
        lambda: dc.Coulomb(0.1, duration=1.0),
        lambda: dc.Coulomb("rough"),
        lambda: dc.Coulomb(0.1, augmented=1),
    ):
        with pytest.raises(dc.InputError):
            make()


def test_laws_are_values():
    friction = dc.Coulomb(COEFFICIENTS[0][0], STIFFNESS, duration=DURATION, augmented=True)
    assert pickle.loads(pickle.dumps(friction)) == copy.deepcopy(friction) == friction
    again = pickle.loads(pickle.dumps(TABLE))
    np.testing.assert_array_equal(again.gaps, TABLE.gaps)
    with pytest.raises(ValueError, match="read-only"):
        TABLE.pressures[0] = 2.0
