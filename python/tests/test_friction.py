"""Friction: history, forces and the tangent. A module that was built without it says so."""

import numpy as np
import pytest

import diffuse_contact as dc

PENALTY = 1e3
FRICTION = (0.2, 500.0)


@pytest.fixture
def started(scene):
    """An interface whose slaves have touched, or a test that ends with the reason why there is no friction."""
    interface = scene.interface()
    interface.refresh_pairing(scene.positions)
    try:
        interface.accept(PENALTY, friction=FRICTION)
    except dc.InterfaceError as error:
        assert error.code == "no-friction-kernels"
        assert "feature" in str(error)
        pytest.skip("built without friction")
    return interface


def slid(scene, step):
    positions = scene.positions.copy()
    positions[scene.slaves] += step
    return positions


def at(interface, positions, *, friction=FRICTION):
    interface.refresh_pairing(positions)
    interface.evaluate()
    return interface.forces(PENALTY, friction=friction)


def test_without_friction_nothing_is_to_be_accepted(scene):
    interface = scene.evaluated()
    with pytest.raises(dc.AssemblyError) as raised:
        interface.forces(PENALTY, friction=0.3)
    assert raised.value.code in ("no-slip", "no-friction-kernels")
    with pytest.raises(dc.AssemblyError) as raised:
        interface.forces(PENALTY, friction=-0.3)
    assert raised.value.code == "invalid-friction-coefficient"


@pytest.mark.parametrize("rule", ["domains", "hull-layers"])
def test_a_law_is_refused_where_it_is_handed_in(scene, rule):
    interface = scene.evaluated(rule=rule)
    codes = set()
    for call in (interface.forces, interface.tangent, interface.triplets):
        try:
            call(PENALTY, friction=FRICTION)
        except dc.AssemblyError as error:
            codes.add(error.code)
        else:
            codes.add(None)
    if rule == "hull-layers":
        assert codes == {"no-anchors"}
        return
    try:
        interface.accept(PENALTY, friction=FRICTION)
    except dc.InterfaceError as error:
        assert codes == {error.code} == {"no-friction-kernels"}
    else:
        # Only now does friction have a history.
        assert codes == {"no-slip"}


def test_forces_are_against_the_slip_and_balance(scene, started):
    positions = slid(scene, [0.05, 0.0, 0.0])
    forces = at(started, positions).reshape(-1, 3)
    traction = forces - at(started, positions, friction=None).reshape(-1, 3)
    assert np.all(traction[scene.slaves, 0] < 0.0)
    ratio = np.linalg.norm(traction[scene.slaves], axis=1) / started.normal_forces(PENALTY)
    assert np.allclose(ratio, 0.2, rtol=0.01)
    assert np.abs(forces.sum(axis=0)).max() < 1e-13 * np.abs(forces).max()
    assert np.abs(np.cross(positions, forces).sum(axis=0)).max() < 1e-12 * np.abs(forces).max()


def test_friction_of_slaves_is_what_it_adds_to_the_forces(scene, started):
    positions = slid(scene, [0.05, 0.0, 0.0])
    with pytest.raises(dc.InterfaceError) as raised:
        started.friction(PENALTY, friction=FRICTION)
    assert raised.value.code == "not-evaluated"
    forces, without = (at(started, positions, friction=law).reshape(-1, 3) for law in (FRICTION, None))
    found = started.friction(PENALTY, friction=FRICTION)
    expected = (forces - without)[scene.slaves]
    area = started.contacts.area[:, np.newaxis]
    np.testing.assert_allclose(found.friction * area, expected, atol=1e-12 * np.abs(forces).max())
    assert found.friction_states == ["slip"] * 4
    np.testing.assert_allclose(found.slip, 0.05, atol=5e-3)
    started.update(slid(scene, [0.0, 0.0, 1.0]))
    started.evaluate()
    opened = started.friction(PENALTY, friction=FRICTION)
    assert opened.friction_states == ["open"] * 4 and not opened.friction.any() and not opened.slip.any()


def test_the_tangent_is_the_derivative_of_the_forces(scene, started):
    positions = slid(scene, [0.05, 0.02, 0.0])
    at(started, positions)
    tangent = started.tangent(PENALTY, friction=FRICTION)
    assert np.abs(tangent - tangent.T).max() > 1.0
    direction = np.random.default_rng(3).uniform(-1.0, 1.0, positions.shape)
    h = 1e-6
    ahead, behind = (at(started, positions + step * direction) for step in (h, -h))
    expected = -(ahead - behind) / (2.0 * h)
    assert np.allclose(tangent @ direction.ravel(), expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize("element", ["diffuse", "node-to-facet"])
@pytest.mark.parametrize("tangent", ["exact", "gauss-newton"])
@pytest.mark.parametrize("step", [[0.001, 0.0005, 0.0], [0.05, 0.02, 0.0]])
def test_the_operator_is_the_tangent(scene, element, tangent, step):
    dofs = np.arange(255).reshape(85, 3)[::-1].copy()
    dofs[:4] = -1
    interface = scene.interface(element=element, dofs=dofs)
    interface.refresh_pairing(scene.positions)
    try:
        interface.accept(PENALTY, friction=FRICTION)
    except dc.InterfaceError as error:
        assert error.code == "no-friction-kernels" and element == "diffuse"
        pytest.skip("built without friction")
    interface.refresh_pairing(slid(scene, step))
    law = {"friction": FRICTION, "tangent": tangent, "multipliers": [0.0, 3.0, 0.5, 0.0]}
    # It needs no evaluation.
    operator = interface.operator(PENALTY, **law)
    interface.evaluate()
    matrix = interface.tangent(PENALTY, **law)
    largest = abs(matrix).max()
    if step[0] > 0.01 and tangent == "exact":
        assert abs(matrix - matrix.T).max() > 0.1
    v = np.random.default_rng(5).normal(size=(interface.equations, 2))
    products = [
        (operator @ v, matrix @ v),
        (operator.T @ v, matrix.T @ v),
        (operator.H @ v, matrix.T @ v),
        (operator.diagonal(), matrix.diagonal()),
    ]
    if hasattr(operator, "__array_ufunc__"):
        # Older versions of scipy take no array on the left.
        products.append(((v.T @ operator).T, matrix.T @ v))
    for found, expected in products:
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13 * largest)
    assert operator.contacts == 4


def test_an_operator_is_refused_friction_that_has_no_history(scene):
    interface = scene.evaluated(element="node-to-facet")
    with pytest.raises(dc.AssemblyError) as raised:
        interface.operator(PENALTY, friction=FRICTION)
    assert raised.value.code == "no-slip"
    with pytest.raises(dc.AssemblyError) as raised:
        interface.operator(PENALTY, friction=-0.3)
    assert raised.value.code == "invalid-friction-coefficient"
    with pytest.raises(dc.AssemblyError) as raised:
        scene.evaluated(rule="hull-layers").operator(PENALTY, friction=FRICTION)
    assert raised.value.code == "no-anchors"


def test_any_sequence_of_numbers_is_a_law(scene, started):
    at(started, slid(scene, [0.05, 0.0, 0.0]))
    expected = started.forces(PENALTY, friction=(0.3, 1e3))
    for friction in ([0.3, 1e3], np.array([0.3, 1e3])):
        assert np.array_equal(started.forces(PENALTY, friction=friction), expected)
    for friction in ([0.3], (0.3, 1.0, 2.0, 3.0), np.zeros(0)):
        with pytest.raises(dc.InputError, match="a sequence has 2 or 3 numbers"):
            started.forces(PENALTY, friction=friction)


def test_a_history_goes_on_elsewhere(scene, started):
    at(started, slid(scene, [0.05, 0.0, 0.0]))
    report = started.accept(PENALTY, friction=FRICTION)
    assert (report.stuck, report.sliding, report.unanchored, report.dropped) == (0, 4, 0, 0)
    assert report.dissipated > 0.0
    further = slid(scene, [0.06, 0.0, 0.0])
    other = scene.interface()
    other.history = started.history
    assert np.array_equal(at(other, further), at(started, further))
    with pytest.raises(dc.InterfaceError) as raised:
        other.history = [0.5]
    assert raised.value.code == "invalid-history"
    other.history = []
    assert other.history.size == 0
