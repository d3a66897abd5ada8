import itertools

import pytest
from press import press


@pytest.fixture(scope="module")
def results():
    return {
        "diffuse": press(),
        "facets": press(element="node-to-facet"),
        "fine": press(0.5, element="node-to-facet"),
    }


def test_the_pressing_force(results):
    """On facets of 10° the diffuse surface is within 0.3 % of the cylinder; the facets themselves are 10 % off."""
    diffuse, facets, fine = (results[name].force for name in ("diffuse", "facets", "fine"))
    assert diffuse == pytest.approx(683.741693, rel=1e-6)
    assert facets == pytest.approx(613.221494, rel=1e-6)
    assert fine == pytest.approx(682.214955, rel=1e-6)
    assert abs(diffuse / fine - 1) < 0.003
    assert facets / fine - 1 < -0.1


def test_the_pressure(results):
    assert results["diffuse"].pressure == pytest.approx(results["fine"].pressure, rel=0.005)
    assert results["facets"].pressure > 1.15 * results["fine"].pressure


def test_newton_converges_quadratically(results):
    """Once the set of touching nodes is found, each residual is below the square of the one before."""
    orders = 0
    for residuals in results["diffuse"].residuals:
        assert residuals[-1] < 1e-11 and len(residuals) <= 5
        for before, after in itertools.pairwise(residuals):
            if before < 0.2:
                assert after < before**2 + 1e-12
                orders += before > 1e-6
    assert orders >= 5


def test_an_interpolating_surface_is_no_worse(results):
    force = press(weight="cubic-interpolating").force
    assert force == pytest.approx(results["fine"].force, rel=0.003)
