import numpy as np
import pytest

import diffuse_contact as dc

UP = [0, 0, 1]


def test_derivatives_are_those_of_the_gap(elements):
    slaves, masters = (array[:1] for array in elements)
    result = dc.gap(slaves, masters, UP, support_radius=1.8)
    x = np.concatenate([slaves, masters[0]]).reshape(-1)
    step = 1e-5
    moved = x + step * np.vstack([np.eye(x.size), -np.eye(x.size)])
    moved = moved.reshape(-1, 10, 3)
    around = dc.gap(moved[:, 0], moved[:, 1:], UP, support_radius=1.8, mode="gradient")
    forward, backward = np.split(around.gap, 2)
    np.testing.assert_allclose(result.gradient[0], (forward - backward) / (2 * step), atol=1e-9)
    forward, backward = np.split(around.gradient, 2)
    np.testing.assert_allclose(result.hessian[0], (forward - backward) / (2 * step), atol=1e-8)


def test_modes_have_the_arrays_that_were_asked_for(elements):
    for mode, gradient, hessian in (
        ("value", (5, 0), (5, 0, 0)),
        ("gradient", (5, 30), (5, 0, 0)),
        ("hessian", (5, 30), (5, 30, 30)),
    ):
        result = dc.gap(*elements, UP, mode=mode)
        assert (result.gradient.shape, result.hessian.shape) == (gradient, hessian)
        assert result.ok.all()
    assert dc.gap(*elements, UP, packed=True).hessian.shape == (5, 465)


def test_a_given_frame_is_held(elements):
    slaves, masters = elements
    frames = np.eye(3)
    held = dc.gap(slaves, masters, frames=frames)
    each = dc.gap(slaves, masters, np.tile([0.0, 0.3, 2.0], (5, 1)), frames=np.tile(frames, (5, 1, 1)))
    np.testing.assert_array_equal(held.hessian, each.hessian)
    flipped = dc.gap(slaves, masters, [0, 0, -1], frames=frames)
    np.testing.assert_allclose(flipped.gap, -held.gap, atol=1e-15)
    moving = dc.gap(slaves, masters, UP)
    assert np.abs(moving.gradient - held.gradient).max() > 1e-6


def test_other_layouts_and_types_give_the_same(elements):
    slaves, masters = elements
    expected = dc.gap(slaves, masters, UP).gap
    np.testing.assert_array_equal(dc.gap(np.asfortranarray(slaves), masters[:, ::-1][:, ::-1], UP).gap, expected)
    np.testing.assert_array_equal(dc.gap(np.repeat(slaves, 2, axis=0)[::2], masters, UP).gap, expected)
    np.testing.assert_array_equal(dc.gap(slaves.tolist(), masters.tolist(), UP).gap, expected)
    single = dc.gap(slaves.astype(np.float32), masters.astype(np.float32), UP)
    assert single.gap.dtype == np.float64
    np.testing.assert_allclose(single.gap, expected, atol=1e-6)
    swapped = dc.gap(slaves.astype(">f8"), masters.astype(">f8"), UP)
    np.testing.assert_array_equal(swapped.gap, expected)
    integers = dc.gap([[0, 0, 1]], np.round(masters[:1]).astype(np.int32) * [1, 1, 0], UP)
    np.testing.assert_allclose(integers.gap, [1.0], atol=1e-14)


def test_results_can_be_written_to_the_same_memory(elements):
    out = dc.GapBatch.empty(5, 9, packed=True)
    result = dc.gap(*elements, UP, packed=True, out=out)
    assert result is out
    np.testing.assert_array_equal(out.hessian, dc.gap(*elements, UP, packed=True).hessian)
    for bad in (
        dc.GapBatch.empty(5, 9),
        dc.GapBatch.empty(4, 9, packed=True),
        dc.GapBatch(out.gap[::-1], out.foot, out.normal, out.gradient, out.hessian, out.status),
    ):
        with pytest.raises(dc.InputError) as caught:
            dc.gap(*elements, UP, packed=True, out=bad)
        assert caught.value.code == "wrong-shape"
    overlapping = dc.GapBatch(out.gap, out.foot, out.foot, out.gradient, out.hessian, out.status)
    with pytest.raises(dc.InputError) as caught:
        dc.gap(*elements, UP, packed=True, out=overlapping)
    assert caught.value.code == "overlap"


def test_no_elements_are_no_error():
    result = dc.gap(np.empty((0, 3)), np.empty((0, 9, 3)), UP)
    assert result.gap.shape == (0,) and result.hessian.shape == (0, 30, 30)


def test_an_element_without_result_is_named(elements):
    slaves, masters = (array.copy() for array in elements)
    masters[1] = masters[1, :1]
    masters[2, 4, 1] = np.nan
    slaves[3] = [np.inf, 0, 0]
    with pytest.raises(dc.ElementError) as caught:
        dc.gap(slaves, masters, UP)
    assert (caught.value.code, caught.value.index) == ("no-average-plane", 1)
    assert "element 1: the master nodes have no average plane" in str(caught.value)
    result = dc.gap(slaves, masters, UP, on_error="status")
    assert result.codes() == ["ok", "no-average-plane", "non-finite-input", "non-finite-input", "ok"]
    assert result.ok.tolist() == [True, False, False, False, True]
    for array in (result.gap, result.foot, result.normal, result.gradient, result.hessian):
        assert np.isfinite(array[result.ok]).all()
        assert np.isnan(array[~result.ok]).all()
    np.testing.assert_array_equal(result.hessian[0], dc.gap(*elements, UP).hessian[0])


@pytest.mark.parametrize(
    ("change", "code"),
    [
        ({"support_radius": 0.0}, "invalid-support-radius"),
        ({"support_radius": np.nan}, "invalid-support-radius"),
        ({"support_radius": 0.5}, "singular-fit"),
        ({"outward": [1, 0, 0]}, "ambiguous-outward"),
        ({"outward": [0, 0, 0]}, "ambiguous-outward"),
        ({"frames": 2 * np.eye(3)}, "invalid-frame"),
        ({"frames": np.full((3, 3), np.nan)}, "invalid-frame"),
    ],
)
def test_reasons_of_elements(elements, change, code):
    slaves, masters = elements
    masters = masters * [1, 1, 0.1]
    with pytest.raises(dc.ElementError) as caught:
        dc.gap(slaves, masters, **{"outward": UP, **change})
    assert caught.value.code == code
    assert code in dc.STATUS_CODES


def test_too_few_masters(elements):
    slaves, masters = elements
    with pytest.raises(dc.ElementError, match="2 master nodes") as caught:
        dc.gap(slaves, masters[:, :2], UP)
    assert caught.value.code == "too-few-nodes"
    with pytest.raises(dc.ElementError) as caught:
        dc.gap(slaves, masters[:, :5], UP, basis="quadratic")
    assert caught.value.code == "too-few-nodes"
    with pytest.raises(dc.ElementError):
        dc.gap(slaves, masters[:, :0], UP)


@pytest.mark.parametrize(
    ("arguments", "options", "code"),
    [
        ((np.zeros((5, 2)), None), {}, "wrong-shape"),
        ((np.zeros(3), None), {}, "wrong-shape"),
        ((None, np.zeros((4, 9, 3))), {}, "wrong-shape"),
        ((None, np.zeros((9, 3))), {}, "wrong-shape"),
        ((np.zeros((5, 3), dtype=complex), None), {}, "wrong-type"),
        ((np.full((5, 3), "1"), None), {}, "wrong-type"),
        ((np.full((5, 3), None), None), {}, "wrong-type"),
        (([[0, 0, 0], [0, 0]], None), {}, "wrong-shape"),
        ((None, None), {"outward": np.zeros((4, 3))}, "wrong-shape"),
        ((None, None), {"outward": None}, "missing-outward"),
        ((None, None), {"frames": np.zeros((4, 3, 3))}, "wrong-shape"),
        ((None, None), {"frames": np.eye(3), "frame_derivative": "co-moving"}, "co-moving-given-frame"),
        ((None, None), {"support_radius": [1.0, 2.0]}, "wrong-shape"),
        ((None, None), {"support_radius": "wide"}, "wrong-type"),
        ((None, None), {"mode": "values"}, "invalid-option"),
        ((None, None), {"mode": 2}, "wrong-type"),
        ((None, None), {"weight": "gauss"}, "invalid-option"),
        ((None, None), {"basis": "cubic"}, "invalid-option"),
        ((None, None), {"frame_derivative": "moving"}, "invalid-option"),
        ((None, None), {"on_error": "ignore"}, "invalid-option"),
    ],
)
def test_bad_arguments_are_refused_with_a_sentence(elements, arguments, options, code):
    given = [new if new is not None else old for new, old in zip(arguments, elements, strict=True)]
    with pytest.raises(dc.InputError) as caught:
        dc.gap(*given, **{"outward": UP, **options})
    assert caught.value.code == code
    assert len(caught.value.message.split()) > 4
    assert isinstance(caught.value, ValueError)


def test_any_numbers_end_in_a_status():
    random = np.random.default_rng(1)
    special = np.array([0.0, -0.0, 1e-320, 1e-160, 1.0, -1.0, 1e75, 1e160, 1e300, np.inf, -np.inf, np.nan])
    for nodes in (3, 6, 11):
        slaves = random.choice(special, (400, 3))
        masters = random.choice(special, (400, nodes, 3))
        masters[::2] = random.normal(size=(200, nodes, 3)) * 10.0 ** random.integers(-200, 200, (200, 1, 1))
        for weight in ("cubic", "cubic-interpolating", "wendland-c2"):
            result = dc.gap(slaves, masters, random.normal(size=3), weight=weight, on_error="status")
            for array in (result.gap, result.foot, result.normal, result.gradient, result.hessian):
                assert np.isfinite(array[result.ok]).all()
            assert "other" not in result.codes()
