import copy
import dataclasses
import pickle

import numpy as np
import pytest
import scipy.sparse

import diffuse_contact as dc
from diffuse_contact import _native


def test_defaults_are_those_of_the_rust_library():
    defaults = _native.default_options()
    options = dc.Options()
    assert {name: getattr(options, name) for name in defaults} == defaults
    assert (options.element, options.frame_derivative, options.rule) == ("diffuse", "co-moving", "domains")


def test_the_example_of_the_documentation(scene):
    interface = scene.interface(slave_facets=scene.slave_facets)
    assert interface.slaves.tolist() == [81, 82, 83, 84]
    report = interface.refresh_pairing(scene.positions)
    assert (report.paired, report.gained, report.without) == (4, 4, {})
    interface.update(scene.positions)
    contacts = interface.evaluate()
    assert contacts.is_contact.all() and contacts.outcomes == ["contact"] * 4
    assert abs(contacts.gap[0] + 0.068) < 1e-3
    np.testing.assert_array_equal(contacts.penetration, -contacts.gap)
    assert contacts.area.sum() == pytest.approx(1.7**2)
    forces = interface.forces(1e4).reshape(-1, 3)
    assert np.abs(forces.sum(axis=0)).max() < 1e-9
    assert np.abs(np.cross(scene.positions, forces).sum(axis=0)).max() < 1e-8
    normal_forces = interface.normal_forces(1e4)
    np.testing.assert_allclose(normal_forces, -1e4 * contacts.area * contacts.gap)
    np.testing.assert_allclose(interface.pressures(1e4), -1e4 * contacts.gap)


@pytest.mark.parametrize("element", ["diffuse", "node-to-facet"])
def test_the_tangent_is_the_derivative_of_the_residual(scene, element):
    interface = scene.evaluated(element=element)
    matrix = interface.tangent(1e3)
    assert isinstance(matrix, scipy.sparse.csr_matrix) and matrix.has_sorted_indices
    assert abs(matrix - matrix.T).max() == 0.0
    random = np.random.default_rng(2)
    direction = random.normal(size=scene.positions.shape)
    step = 1e-6
    ends = []
    for sign in (1, -1):
        interface.update(scene.positions + sign * step * direction)
        interface.evaluate("gradient")
        ends.append(interface.forces(1e3))
    slope = -(ends[0] - ends[1]) / (2 * step)
    np.testing.assert_allclose(matrix @ direction.reshape(-1), slope, atol=1e-4)


def test_pattern_triplets_and_values_agree(scene):
    interface = scene.evaluated()
    matrix = interface.tangent(1e3)
    offsets, columns = interface.pattern()
    assert offsets[-1] == len(columns) == matrix.nnz
    rows, columns, values = interface.triplets(1e3)
    summed = scipy.sparse.coo_matrix((values, (rows, columns)), shape=matrix.shape).tocsr()
    assert abs(summed - matrix).max() < 1e-9
    lower = interface.triplets(1e3, triangle="lower")
    assert (lower[0] >= lower[1]).all() and len(lower[2]) < len(values)
    values = interface.tangent_values(1e3)
    twice = interface.tangent_values(1e3, out=values.copy())
    np.testing.assert_allclose(twice, 2 * values)
    # The union pattern does not depend on who carries force, and a matrix belongs to its caller.
    interface.update(scene.positions + np.where(np.arange(85) > 80, 0.5, 0.0)[:, np.newaxis] * [0, 0, 1])
    interface.evaluate()
    with pytest.raises(ValueError, match="read-only"):
        matrix.eliminate_zeros()
    matrix = matrix.copy()
    matrix.eliminate_zeros()
    apart = interface.tangent(1e3)
    assert apart.nnz == len(values) and not apart.data.any()
    np.testing.assert_array_equal(interface.forces(1e3), np.zeros(255))


def test_residual_is_added_to_what_is_there(scene):
    interface = scene.evaluated()
    out = np.ones(255)
    assert interface.forces(1e3, out=out) is out
    np.testing.assert_allclose(out, 1 + interface.forces(1e3))
    for bad in (np.ones(255, dtype=np.float32), np.ones(510)[::2], [0.0] * 255, np.ones((85, 3))):
        with pytest.raises(dc.InputError):
            interface.forces(1e3, out=bad)
    with pytest.raises(dc.AssemblyError) as caught:
        interface.forces(1e3, out=np.ones(254))
    assert caught.value.code == "output-length"


def test_equations_of_the_caller(scene):
    dofs = np.full((85, 3), -1)
    dofs[81:, 2] = [5, 1, 0, 3]
    interface = scene.evaluated(dofs=dofs, equations=7)
    free = scene.evaluated()
    residual = interface.forces(1e3)
    assert interface.equations == 7 and residual.shape == (7,)
    np.testing.assert_array_equal(residual[[5, 1, 0, 3]], free.forces(1e3).reshape(-1, 3)[81:, 2])
    assert interface.tangent(1e3).shape == (7, 7)
    assert scene.interface(dofs=dofs).equations == 6
    dofs[81, 2] = 1
    with pytest.raises(dc.AssemblyError) as caught:
        scene.interface(dofs=dofs)
    assert caught.value.code == "shared-equation"
    dofs[81, 2] = -2
    with pytest.raises(dc.InputError) as caught:
        scene.interface(dofs=dofs)
    assert caught.value.code == "negative-index"
    with pytest.raises(dc.InputError):
        scene.interface(equations=4)


def test_one_contact_with_its_derivatives(scene):
    # Its element has one domain of influence, as those of dc.gap.
    interface = scene.evaluated(rule="hull-layers")
    contact = interface.contact(2)
    n = len(contact.masters)
    assert (contact.slave, contact.outcome, contact.reason, contact.fallback) == (83, "contact", None, "none")
    assert contact.gradient.shape == (3 * (n + 1),) and contact.hessian.shape == (3 * (n + 1), 3 * (n + 1))
    np.testing.assert_array_equal(contact.hessian, contact.hessian.T)
    np.testing.assert_allclose(contact.gradient.reshape(-1, 3).sum(axis=0), 0, atol=1e-13)
    pairing = interface.pairing(2)
    assert pairing.masters.tolist() == contact.masters.tolist() and pairing.basis == "quadratic"
    again = dc.gap(
        scene.positions[83:84],
        pairing.positions[np.newaxis],
        pairing.frame[2],
        support_radius=pairing.support_radius,
        mode="gradient",
    )
    np.testing.assert_allclose(again.gradient[0], contact.gradient, atol=1e-13)
    interface.evaluate("value")
    assert interface.contact(2).gradient is None
    facet = scene.evaluated(element="node-to-facet")
    assert facet.pairing(0).positions.shape == (4, 3) and facet.pairing(0).frame is None
    with pytest.raises(dc.InputError) as caught:
        interface.contact(4)
    assert caught.value.code == "no-such-slave"


def test_outcomes_of_slaves_without_contact(scene):
    scene.positions[82] = [-3, 4, 0]
    scene.positions[83] = [4, 4, 30]
    interface = scene.interface(distance_limit=10.0)
    with pytest.raises(dc.InterfaceError) as caught:
        interface.pairing(0)
    assert caught.value.code == "not-paired"
    with pytest.raises(dc.InterfaceError) as caught:
        interface.evaluate()
    assert caught.value.code == "not-refreshed"
    report = interface.refresh_pairing(scene.positions)
    assert report.without == {"beyond-border": 1, "too-far": 1}
    contacts = interface.evaluate()
    assert contacts.outcomes == ["contact", "beyond-border", "too-far", "contact"]
    assert np.isnan(contacts.gap).tolist() == [False, True, True, False]
    assert contacts.penetration[1] == 0.0
    assert interface.normal_forces(1.0)[1:3].tolist() == [0.0, 0.0]
    contact = interface.contact(2)
    assert contact.gap is None and "away, beyond the limit of" in contact.reason


def test_results_of_old_positions_are_not_handed_out(scene):
    interface = scene.interface()
    for refreshed, stale in (
        (False, lambda: None),
        (True, lambda: interface.refresh_pairing(scene.positions)),
        (True, lambda: interface.update(scene.positions)),
    ):
        stale()
        for ask in (
            lambda: interface.contacts,
            lambda: interface.contact(0),
            lambda: interface.forces(1.0),
            lambda: interface.tangent(1.0),
            lambda: interface.triplets(1.0),
            lambda: interface.normal_forces(1.0),
            lambda: interface.cut_back(),
        ):
            with pytest.raises(dc.InterfaceError) as caught:
                ask()
            assert caught.value.code == "not-evaluated"
        if refreshed:
            interface.evaluate()
            interface.forces(1.0)


def test_an_interface_may_have_no_slaves(scene):
    """As a rank of a distributed program that owns none."""
    interface = dc.ContactInterface(scene.master(), [], scene.positions, slave_facets=np.empty((0, 4), dtype=int))
    assert interface.refresh_pairing(scene.positions).paired == 0
    assert interface.evaluate().gap.shape == (0,)
    assert not interface.forces(1.0).any() and interface.tangent(1.0).shape == (255, 255)
    assert interface.triplets(1.0)[0].shape == (0,) and interface.cut_back().factor == 1.0


def test_the_refresh_reports_jumps(scene):
    interface = scene.evaluated(rule="hull-layers")
    moved = scene.positions.copy()
    moved[81:, :2] += 0.6
    report = interface.refresh_pairing(moved)
    assert report.changed > 0 and isinstance(report.largest_gap_jump, dc.GapJump)
    assert report.largest_gap_jump.slave in range(81, 85)


def test_the_refresh_reports_what_was_lost(scene):
    interface = scene.evaluated(distance_limit=0.3)
    lifted = scene.positions + 0.6 * (np.arange(85) == 82)[:, np.newaxis] * [0, 0, 1]
    report = interface.refresh_pairing(lifted)
    assert (report.lost, report.contacts_lost, report.without) == (1, 1, {"too-far": 1})
    assert report.smallest_gap_lost.slave == 82 and report.smallest_gap_lost.gap > 0.3
    report = interface.refresh_pairing(scene.positions)
    assert report.contacts_gained == 1 and report.smallest_gap_gained.gap < 0
    assert interface.follow(lifted)
    report = interface.refresh_pairing(lifted)
    assert (report.lost, report.contacts_lost, report.smallest_gap_lost.slave) == (0, 1, 82)
    assert interface.refresh_pairing(lifted).contacts_lost == 0


def test_a_frozen_interface_keeps_its_pairing_and_moves(scene):
    interface = scene.evaluated()
    pattern, masters, gap = interface.pattern(), interface.contact(0).masters, interface.contacts.gap
    moved = scene.positions.copy()
    moved[81:, :2] += 0.6
    assert not interface.frozen
    interface.freeze()
    report = interface.refresh_pairing(moved)
    assert interface.frozen and report.frozen and report.paired == report.changed == 0
    with pytest.raises(dc.InterfaceError) as caught:
        interface.forces(1.0)
    assert caught.value.code == "not-evaluated", "the positions were taken over"
    assert (interface.evaluate().gap != gap).all()
    np.testing.assert_array_equal(interface.contact(0).masters, masters)
    np.testing.assert_array_equal(interface.pattern()[1], pattern[1])
    bad = moved.copy()
    bad[3] = np.nan
    with pytest.raises(dc.InterfaceError):
        interface.refresh_pairing(bad)
    interface.contact(0)
    interface.thaw()
    report = interface.refresh_pairing(moved)
    assert not interface.frozen and not report.frozen and report.paired == 4 and report.changed > 0


def test_lists_of_nodes_follow(scene):
    interface = scene.interface()
    assert not interface.follow(scene.positions), "there are none yet"
    report = interface.refresh_pairing(scene.positions)
    assert report.rebuilt and report.fallbacks == {"none": 4, "extended": 0, "linear": 0} and report.deep == 0
    here = interface.evaluate().gap
    pattern = interface.pattern()
    moved = {by: scene.positions.copy() for by in (0.01, 0.6)}
    for by, positions in moved.items():
        positions[81:, :2] += by
    assert not interface.follow(moved[0.01])
    report = interface.refresh_pairing(moved[0.01])
    assert not report.rebuilt and report.kept == 4 and report.largest_gap_jump is None
    report = interface.refresh_pairing(moved[0.01], renew=True)
    assert report.rebuilt and report.kept == 0 and report.largest_gap_jump is None
    assert not interface.refresh_pairing(moved[0.01]).rebuilt
    assert (interface.evaluate().gap != here).all()
    np.testing.assert_array_equal(interface.pattern()[1], pattern[1])
    interface.freeze()
    assert not interface.follow(moved[0.6])
    report = interface.refresh_pairing(moved[0.6])
    assert report.frozen and not report.rebuilt
    interface.thaw()
    assert interface.follow(moved[0.6])
    interface.evaluate()
    assert not np.array_equal(interface.pattern()[1], pattern[1])
    # Back there are the gaps of the beginning, whatever the lists are.
    assert interface.follow(scene.positions)
    np.testing.assert_allclose(interface.evaluate().gap, here, rtol=0, atol=1e-14)
    with pytest.raises(dc.InterfaceError):
        interface.follow(scene.positions[:80])


def test_domains_stretch_with_the_master(scene):
    """No refresh changes a gap, and it does not matter by which way a position is reached."""
    interface = scene.evaluated()
    last, rebuilt = interface.contacts.gap, 0
    for step in range(1, 51):
        stretched = scene.positions * [1, 1 + 0.02 * step, 1]
        interface.update(stretched)
        before = interface.evaluate().gap
        report = interface.refresh_pairing(stretched)
        assert report.paired == report.fallbacks["none"] == 4 and report.largest_gap_jump is None
        rebuilt += report.rebuilt
        after = interface.evaluate().gap
        np.testing.assert_allclose(after, before, rtol=0, atol=1e-13)
        np.testing.assert_allclose(after, last, rtol=0, atol=2e-3)
        last = after
    assert rebuilt > 1, "the lists have followed"
    direct = scene.interface()
    direct.refresh_pairing(stretched)
    np.testing.assert_allclose(direct.evaluate().gap, last, rtol=0, atol=1e-13)
    # Made there, an interface has that for its first configuration.
    another = dc.ContactInterface(scene.master(), scene.slaves, stretched)
    another.refresh_pairing(stretched)
    assert (another.evaluate().gap != last).all()


def test_a_slave_far_away_has_a_gap_like_any_other(scene):
    lifted = scene.positions + 4.0 * (np.arange(85) > 80)[:, np.newaxis] * [0, 0, 1]
    interface = scene.interface()
    assert interface.refresh_pairing(lifted).fallbacks["none"] == 4
    gap = interface.evaluate().gap
    foot = np.linspace(0, 8, 100001)
    for k in range(4):
        x, _, z = lifted[81 + k]
        distance = np.hypot(x - foot, z + 0.05 * (foot - 4) ** 2).min()
        assert gap[k] == pytest.approx(distance, abs=2e-3)
        assert interface.contact(k).fallback == "none"


def test_domains_of_influence_are_those_within_reach(scene):
    interface = scene.evaluated()
    pairing, contact = interface.pairing(2), interface.contact(2)
    material, count = pairing.material, len(pairing.masters)
    assert set(pairing.masters) < set(contact.masters)
    assert material.offsets.shape == (count, 3) and material.metrics.shape == (count, 3, 3)
    assert not np.tril(material.metrics, -1).any() and (material.distances < 1).all()
    np.testing.assert_allclose(
        material.distances[0], np.linalg.norm(material.metrics[0] @ material.offsets[0]), rtol=1e-14
    )
    np.testing.assert_array_equal(pairing.positions, scene.positions[pairing.masters])
    # The interface was made here: the slave's place is close to its foot, and the masters' first positions are these.
    place = pairing.positions - material.offsets
    np.testing.assert_allclose(place, np.broadcast_to(place[0], place.shape), rtol=0, atol=1e-14)
    assert np.linalg.norm(place[0] - contact.foot) < 0.1
    distance = np.linalg.norm(pairing.positions - scene.positions[contact.slave], axis=1)
    assert pairing.support_radius == pytest.approx(distance.max(), rel=1e-14)
    assert scene.evaluated(rule="nearest").pairing(2).material is None
    # A rigid motion changes nothing of it.
    turned = scene.positions @ np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]]) + [3, -2, 1]
    interface.refresh_pairing(turned)
    moved = interface.pairing(2).material
    np.testing.assert_allclose(moved.offsets, material.offsets, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(moved.metrics, material.metrics)


def test_a_held_frame_needs_another_rule(scene):
    with pytest.raises(dc.InterfaceError) as caught:
        scene.interface(frame_derivative="held")
    assert caught.value.code == "held-frame"
    assert scene.evaluated(frame_derivative="held", rule="hull-layers").contacts.is_contact.all()


def test_beyond_planes_of_symmetry_the_surface_goes_on(scene):
    """Half of the ridge with its mirror image is the whole of it."""
    x = scene.positions[:, 0]
    scene.positions[81:, :2] = [[4.3, 3.7], [4.3, 4.4], [4.1, 4.6], [5.2, 3.9]]
    whole = scene.evaluated()
    expected = whole.contacts
    half = dc.MasterSurface(scene.positions, scene.facets[(x[scene.facets] >= 4).all(axis=1)])
    arguments = (half, scene.slaves, scene.positions)
    interface = dc.ContactInterface(*arguments, symmetry=[([4, 0, 0], [1, 0, 0])])
    interface.refresh_pairing(scene.positions)
    contacts = interface.evaluate()
    np.testing.assert_allclose(contacts.gap, expected.gap, rtol=0, atol=1e-12)
    np.testing.assert_allclose(contacts.normal, expected.normal, rtol=0, atol=1e-12)
    alone = dc.ContactInterface(*arguments)
    alone.refresh_pairing(scene.positions)
    assert (alone.evaluate().gap != expected.gap).any()
    for symmetry, error, code in [
        ([([4, 0, 0], [2, 0, 0])], dc.InterfaceError, "invalid-symmetry"),
        ([([4, 0, 0], [np.nan, 0, 0])], dc.InterfaceError, "invalid-symmetry"),
        ([([5, 0, 0], [1, 0, 0])], dc.InterfaceError, "cut-by-symmetry"),
        ([([4, 0, 0],)], dc.InputError, "wrong-shape"),
        ([[4, 0, 0]], dc.InputError, "wrong-shape"),
        ("x", dc.InputError, "wrong-type"),
        (None, dc.InputError, "wrong-type"),
    ]:
        with pytest.raises(error) as caught:
            dc.ContactInterface(*arguments, symmetry=symmetry)
        assert caught.value.code == code
    with pytest.raises(dc.InterfaceError) as caught:
        dc.ContactInterface(*arguments, symmetry=[([4, 0, 0], [1, 0, 0])], rule="hull-layers")
    assert caught.value.code == "no-symmetry"


def test_adaptive_tangent(scene):
    assert dc.adaptive_tangent(0.3, 1) == "exact" and dc.adaptive_tangent(np.nextafter(0.3, 1), 1) == "gauss-newton"
    assert dc.adaptive_tangent(0, 0) == "exact" and dc.adaptive_tangent(np.nan, 1) == "gauss-newton"
    for norms in (("large", 1.0), (1.0, None), (np.zeros(1), 1.0), (1j, 1.0)):
        with pytest.raises(dc.InputError):
            dc.adaptive_tangent(*norms)
    interface = scene.evaluated()
    far, near = (interface.tangent(1e3, tangent=dc.adaptive_tangent(norm, 1.0)) for norm in (0.5, 0.1))
    assert (near != interface.tangent(1e3)).nnz == 0 and (far != near).nnz > 0


@pytest.mark.parametrize(
    ("rule", "through", "outcome", "factor"),
    [
        ("hull-layers", [0, 0, -40], "foot-outside", 0.5),
        # The centre of curvature of the crest lies 10 below it.
        ("domains", [0.8, 0, -12], "singular-fit", 0.25),
    ],
)
def test_cut_back(scene, rule, through, outcome, factor):
    interface = scene.evaluated(rule=rule)
    assert interface.cut_back() == (1.0, None, None)
    pairing = interface.pairing(0)
    reach = pairing.support_radius
    if rule == "domains":
        # The shortest half axis of the domains listed, which are here those within reach and a little more.
        reach = (1 / np.linalg.svd(pairing.material.metrics, compute_uv=False).max(axis=1)).min()
    moved = scene.positions.copy()
    moved[81, 2] -= 0.5 * reach
    interface.update(moved)
    depth = interface.evaluate().penetration[0]
    hint = interface.cut_back()
    assert hint.slave == 81 and hint.outcome == "contact"
    assert hint.factor == pytest.approx(0.25 * reach / depth)
    # Far through the ridge its element has no result.
    moved[82] += through
    interface.update(moved)
    contacts = interface.evaluate()
    assert contacts.outcomes[1] == outcome
    assert interface.cut_back(limit=10.0) == (factor, 82, outcome)
    # It does not matter how often it is evaluated.
    interface.evaluate()
    interface.evaluate("value")
    assert interface.cut_back(limit=10.0) == (factor, 82, outcome)
    interface.update(scene.positions)
    interface.evaluate()
    assert interface.cut_back() == (1.0, None, None)
    for limit in (0, -1, np.nan, np.inf, "half"):
        with pytest.raises(dc.InputError):
            interface.cut_back(limit)


@pytest.mark.parametrize(
    ("change", "error", "code"),
    [
        ({"slaves": [81, 81]}, dc.InterfaceError, "repeated-slave"),
        ({"slaves": [0, 81]}, dc.InterfaceError, "slave-on-master"),
        ({"slaves": [81, 85]}, dc.InterfaceError, "slave-out-of-range"),
        ({"slaves": [-1]}, dc.InputError, "negative-index"),
        ({"slaves": [81.0]}, dc.InputError, "wrong-type"),
        ({"slaves": [[81]]}, dc.InputError, "wrong-shape"),
        ({"slave_facets": [[81, 82, 83]]}, dc.InterfaceError, "slave-without-area"),
        ({"slave_facets": [[81, 82, 83, 99]]}, dc.InterfaceError, "node-out-of-range"),
        ({"slave_facets": [[81, 82]]}, dc.InputError, "wrong-shape"),
        ({"weight": "gauss"}, dc.InputError, "invalid-option"),
        ({"wieght": "cubic"}, dc.InputError, "unknown-option"),
        ({"element": 3}, dc.InputError, "wrong-type"),
        ({"feature_angle": 200}, dc.InterfaceError, "invalid-option"),
        ({"border_tolerance": np.nan}, dc.InterfaceError, "invalid-option"),
        ({"border_tolerance": "much"}, dc.InputError, "wrong-type"),
        ({"rule": "hull-layers", "layers": 0}, dc.InterfaceError, "invalid-option"),
        ({"max_layers": -1}, dc.InputError, "invalid-option"),
        ({"max_layers": 2.5}, dc.InputError, "wrong-type"),
        ({"linear_fallback": "no"}, dc.InputError, "wrong-type"),
        ({"linear_fallback": 1}, dc.InputError, "wrong-type"),
        ({"distance_limit": 0.0}, dc.InterfaceError, "invalid-option"),
    ],
)
def test_bad_interfaces_are_refused(scene, change, error, code):
    arguments = {"slaves": scene.slaves, **change}
    with pytest.raises(error) as caught:
        dc.ContactInterface(scene.master(), positions=scene.positions, **arguments)
    assert caught.value.code == code


@pytest.mark.parametrize(
    ("name", "meant"),
    [("wieght", "weight"), ("Basis", "basis"), ("feature_angel", "feature_angle"), ("slave_facet", "slave_facets")],
)
def test_a_misspelt_option_names_the_nearest(scene, name, meant):
    with pytest.raises(dc.InputError) as caught:
        dc.ContactInterface(scene.master(), slaves=scene.slaves, positions=scene.positions, **{name: 1})
    beginning = f"ContactInterface has no option {name!r} (did you mean {meant!r}?); the options are element, weight, "
    assert caught.value.message.startswith(beginning)


def test_an_option_like_no_other_names_none(scene):
    with pytest.raises(dc.InputError, match="has no option 'penalty'; the options are element") as caught:
        dc.ContactInterface(scene.master(), slaves=scene.slaves, positions=scene.positions, penalty=1.0)
    assert caught.value.code == "unknown-option"


def test_bad_positions_leave_the_interface_as_it_was(scene):
    interface = scene.evaluated()
    gap = interface.contacts.gap
    bad = scene.positions.copy()
    bad[10, 1] = np.nan
    for positions, error, code in (
        (bad, dc.InterfaceError, "non-finite-position"),
        (scene.positions[:84], dc.InterfaceError, "wrong-number-of-positions"),
        (scene.positions[:, :2], dc.InputError, "wrong-shape"),
    ):
        for call in (interface.update, interface.refresh_pairing):
            with pytest.raises(error) as caught:
                call(positions)
            assert caught.value.code == code
    np.testing.assert_array_equal(interface.contacts.gap, gap)


def test_bad_laws_are_refused(scene):
    interface = scene.evaluated()
    for penalty in (0.0, -1.0, np.nan, np.inf):
        for ask in (interface.forces, interface.tangent, interface.triplets, interface.normal_forces):
            with pytest.raises(dc.AssemblyError) as caught:
                ask(penalty)
            assert caught.value.code == "invalid-penalty"
    for multipliers, code in (
        ([1.0], "multiplier-count"),
        ([1, 1, 1, -1], "invalid-multiplier"),
        ([1, 1, np.nan, 1], "invalid-multiplier"),
    ):
        for ask in (interface.forces, interface.tangent, interface.normal_forces):
            with pytest.raises(dc.AssemblyError) as caught:
                ask(1.0, multipliers=multipliers)
            assert caught.value.code == code
    with pytest.raises(dc.InputError):
        interface.forces("stiff")
    with pytest.raises(dc.InputError):
        interface.tangent(1.0, tangent="secant")
    interface.evaluate("gradient")
    with pytest.raises(dc.AssemblyError) as caught:
        interface.triplets(1.0)
    assert caught.value.code == "derivative-length"
    assert interface.tangent(1.0, tangent="gauss-newton").nnz > 0


def test_errors_survive_pickling(scene):
    with pytest.raises(dc.InterfaceError) as caught:
        scene.interface().forces(1.0)
    loaded = pickle.loads(pickle.dumps(caught.value))
    assert (type(loaded), loaded.code, str(loaded)) == (dc.InterfaceError, "not-evaluated", str(caught.value))


def fields(value):
    """Those of structures inside it are fields like its own."""
    values = [getattr(value, field.name) for field in dataclasses.fields(value)]
    return [one for value in values for one in (fields(value) if dataclasses.is_dataclass(value) else [value])]


def test_what_an_interface_answers_survives_pickling(scene):
    interface = scene.interface(weight="wendland-c2", distance_limit=2.0)
    report = interface.refresh_pairing(scene.positions)
    interface.evaluate()
    for value in (interface.options, report, interface.cut_back()):
        assert pickle.loads(pickle.dumps(value)) == value
        assert copy.deepcopy(value) == value
    for value in (interface.pairing(1), interface.contact(1), interface.contacts, interface.foot_derivatives()):
        loaded = pickle.loads(pickle.dumps(value))
        assert type(loaded) is type(value)
        for found, expected in zip(fields(loaded), fields(value), strict=True):
            np.testing.assert_array_equal(found, expected)
    options = pickle.loads(pickle.dumps(interface.options))
    again = dc.ContactInterface(scene.master(), scene.slaves, scene.positions, **dataclasses.asdict(options))
    assert again.options == interface.options


@pytest.mark.parametrize("clone", [pickle.dumps, copy.copy, copy.deepcopy])
def test_interfaces_and_surfaces_are_not_pickled(scene, clone):
    with pytest.raises(TypeError, match=r"a ContactInterface cannot be pickled or copied: .* make one in each process"):
        clone(scene.evaluated())
    with pytest.raises(TypeError, match=r"a MasterSurface cannot be pickled or copied: .* make one in each process"):
        clone(scene.master())


def test_points_between_two_nodes_name_both():
    x = np.repeat(np.arange(13.0), 2)
    y = np.tile([0.0, 1.0], 13)
    nodes = np.column_stack([x, y, -0.01 * (x - 6.0) ** 2])
    first = 2 * np.arange(12)
    facets = np.column_stack([first, first + 2, first + 3, first + 1])
    positions = np.vstack([nodes, [[5.7, 0.4, 0.02]]])
    interface = dc.ContactInterface(dc.MasterSurface(positions, facets), [26], positions)
    interface.refresh_pairing(positions)
    pairing = interface.pairing(0)
    assert pairing.basis == "quadratic"
    assert pairing.others is not None
    assert pairing.parts is not None
    assert (pairing.parts > 0.0).any()
    part = pairing.parts[:, np.newaxis]
    places = (1.0 - part) * positions[pairing.masters] + part * positions[pairing.others]
    np.testing.assert_allclose(places, pairing.positions, atol=1e-14)
