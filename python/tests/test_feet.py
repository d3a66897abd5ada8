"""The feet with their derivatives: against a plane's closed form, differences and the gradient of the gap."""

import numpy as np
import pytest
from scipy.sparse import bsr_matrix, csr_matrix

import diffuse_contact as dc


def matrices(feet, nodes):
    """Weights, and derivatives of foot and normal, as sparse matrices over all nodes."""
    slaves = len(feet.gap)
    weights = csr_matrix((feet.weights, feet.nodes, feet.offsets), shape=(slaves, nodes))
    shape = (3 * slaves, 3 * nodes)
    of = (feet.nodes, feet.offsets)
    return (
        weights,
        bsr_matrix((feet.foot_jacobian, *of), shape=shape),
        bsr_matrix((feet.normal_jacobian, *of), shape=shape),
    )


def test_on_a_plane_they_have_a_closed_form(scene):
    scene.positions[:81, 2] = 0
    interface = scene.interface()
    interface.refresh_pairing(scene.positions)
    feet = interface.foot_derivatives()
    assert feet.is_contact.all() and feet.outcomes == ["contact"] * 4
    np.testing.assert_allclose(feet.gap, -0.1, rtol=0, atol=1e-14)
    np.testing.assert_allclose(feet.normal, np.tile([0.0, 0, 1], (4, 1)), rtol=0, atol=1e-14)
    weights, foot, normal = matrices(feet, 85)
    # A quadratic field is reproduced.
    x, y, _ = scene.positions.T
    field = 2 + x - 0.5 * y + 0.3 * x * y - 0.2 * y * y
    np.testing.assert_allclose(weights @ field, field[81:], rtol=0, atol=1e-12)
    np.testing.assert_allclose(weights @ scene.positions, feet.foot, rtol=0, atol=1e-12)
    # The foot moves with its slave along the plane, and across with the masters.
    own = feet.offsets[:-1]
    assert feet.nodes[own].tolist() == scene.slaves.tolist() and not feet.weights[own].any()
    np.testing.assert_allclose(feet.foot_jacobian[own], np.tile(np.diag([1.0, 1, 0]), (4, 1, 1)), rtol=0, atol=1e-12)
    np.testing.assert_allclose(feet.normal_jacobian[own], 0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(feet.foot_jacobian[:, 2, 2], feet.weights, rtol=0, atol=1e-12)
    # Turned about an axis of the plane: of the normal, and of the foot below it.
    turn = np.cross([0.0, 1, 0], scene.positions).reshape(-1)
    np.testing.assert_allclose((normal @ turn).reshape(-1, 3), np.tile([1.0, 0, 0], (4, 1)), rtol=0, atol=1e-12)
    np.testing.assert_allclose((foot @ turn).reshape(-1, 3), np.cross([0.0, 1, 0], feet.foot), rtol=0, atol=1e-12)


@pytest.mark.parametrize("options", [{}, {"rule": "hull-layers"}, {"element": "node-to-facet"}], ids=str)
def test_they_are_those_of_differences(scene, options):
    interface = scene.evaluated("gradient", **options)
    contacts, gradients = interface.contacts, [interface.contact(k) for k in range(4)]
    feet = interface.foot_derivatives()
    for name in ("gap", "foot", "normal"):
        np.testing.assert_allclose(getattr(feet, name), getattr(contacts, name), rtol=0, atol=1e-13)
    for k, contact in enumerate(gradients):
        rows = slice(feet.offsets[k], feet.offsets[k + 1])
        assert feet.nodes[rows].tolist() == [contact.slave, *contact.masters]
    weights, foot, normal = matrices(feet, 85)
    np.testing.assert_allclose(weights @ scene.positions, feet.foot, rtol=0, atol=1e-12)
    np.testing.assert_allclose(weights.sum(axis=1), 1, rtol=0, atol=1e-12)
    direction = np.random.default_rng(5).normal(size=scene.positions.shape)
    ends, step = [], 1e-6
    for sign in (1, -1):
        interface.update(scene.positions + sign * step * direction)
        ends.append(interface.evaluate("value"))
    for matrix, name in ((foot, "foot"), (normal, "normal")):
        slope = (getattr(ends[0], name) - getattr(ends[1], name)) / (2 * step)
        np.testing.assert_allclose((matrix @ direction.reshape(-1)).reshape(-1, 3), slope, rtol=0, atol=1e-7)


def test_without_contact_there_are_zeros(scene):
    scene.positions[82] = [-3, 4, 0]
    interface = scene.interface()
    with pytest.raises(dc.InterfaceError) as error:
        interface.foot_derivatives()
    assert error.value.code == "not-refreshed"
    interface.refresh_pairing(scene.positions)
    moved = scene.positions.copy()
    # Beyond the centre of curvature of the crest.
    moved[81] += [0.8, 0, -12]
    interface.update(moved)
    feet, contacts = interface.foot_derivatives(), interface.evaluate()
    assert feet.outcomes == contacts.outcomes == ["singular-fit", "beyond-border", "contact", "contact"]
    assert feet.is_contact.tolist() == [False, False, True, True]
    assert np.isnan(feet.foot[:2]).all() and np.isnan(feet.normal[:2]).all()
    lengths = np.diff(feet.offsets)
    assert lengths[1] == 1 and lengths[0] > 9
    without = slice(0, feet.offsets[2])
    for array in (feet.weights, feet.foot_jacobian, feet.normal_jacobian):
        assert array.shape[0] == feet.offsets[-1] == len(feet.nodes)
        assert not array[without].any() and np.isfinite(array).all()


def test_images_beyond_planes_of_symmetry_add_to_their_nodes(scene):
    """Half of the ridge with its mirror image is the whole of it."""
    x = scene.positions[:, 0]
    scene.positions[81:, :2] = [[4.3, 3.7], [4.3, 4.4], [4.1, 4.6], [5.2, 3.9]]
    half = dc.MasterSurface(scene.positions, scene.facets[(x[scene.facets] >= 4).all(axis=1)])
    interface = dc.ContactInterface(half, scene.slaves, scene.positions, symmetry=[([4, 0, 0], [1, 0, 0])])
    interface.refresh_pairing(scene.positions)
    _, *found = matrices(interface.foot_derivatives(), 85)
    whole = scene.interface()
    whole.refresh_pairing(scene.positions)
    _, *expected = matrices(whole.foot_derivatives(), 85)
    # What is symmetric moves both alike.
    moves = np.random.default_rng(6).normal(size=(85, 3))
    for node, image in ((i + 9 * j, 8 - i + 9 * j) for i in range(4) for j in range(9)):
        moves[node] = moves[image] * [-1, 1, 1]
    moves[:81][x[:81] == 4, 0] = 0
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one @ moves.reshape(-1), other @ moves.reshape(-1), rtol=0, atol=1e-11)
