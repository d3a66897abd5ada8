import itertools

import pytest
from slide import push


@pytest.fixture(scope="module", params=["diffuse", "node-to-facet"])
def increments(request):
    return push(element=request.param)


def test_it_slides_at_its_coefficient(increments):
    pressed, *_, last = increments
    assert abs(pressed.push) < 1e-9 * pressed.force and pressed.report.stuck > 20
    assert last.push == pytest.approx(0.3 * last.force, rel=1e-5)
    assert (last.report.stuck, last.report.sliding, last.report.unanchored) == (0, 36, 0)


def test_the_work_of_the_push_is_dissipated(increments):
    """While all slide the strain energy stays what it is; 0.02 is the way of an increment."""
    before, last = increments[-2:]
    assert last.report.dissipated == pytest.approx(0.02 * 0.5 * (before.push + last.push), rel=1e-2)


def test_newton_converges_quadratically(increments):
    for increment in increments:
        assert len(increment.residuals) <= 6
        for before, after in itertools.pairwise(increment.residuals):
            if before < 1e-3:
                assert after < 10 * before**2 + 1e-12
