import numpy as np
import pytest

import diffuse_contact as dc


class Scene:
    """A ridge of 8 × 8 quadrilaterals, outside above, and four slaves just in it."""

    def __init__(self):
        k = np.arange(81)
        x, y = k % 9, k // 9
        ridge = np.column_stack([x, y, -0.05 * (x - 4.0) ** 2])
        corners = np.arange(64) % 8 + 9 * (np.arange(64) // 8)
        self.facets = np.column_stack([corners, corners + 1, corners + 10, corners + 9])
        slaves = [[3.2, 3.2, -0.1], [3.2, 4.9, -0.1], [4.9, 4.9, -0.1], [4.9, 3.2, -0.1]]
        self.positions = np.vstack([ridge, slaves])
        self.slaves = np.array([81, 82, 83, 84])
        self.slave_facets = [[81, 82, 83, 84]]

    def master(self):
        return dc.MasterSurface(self.positions, self.facets)

    def interface(self, **options):
        return dc.ContactInterface(self.master(), self.slaves, self.positions, **options)

    def evaluated(self, mode="hessian", **options):
        interface = self.interface(**options)
        interface.refresh_pairing(self.positions)
        interface.evaluate(mode)
        return interface


@pytest.fixture
def scene():
    return Scene()


@pytest.fixture
def elements():
    """Slaves (5, 3) and masters (5, 9, 3) of elements on a saddle."""
    grid = np.arange(9)
    x, y = grid % 3 - 1.0, grid // 3 - 1.0
    masters = np.column_stack([x, y, 0.1 * x * x - 0.2 * x * y])
    k = np.arange(5)
    slaves = np.column_stack([0.1 + 0.02 * k, 0.2 - 0.03 * k, 0.05 * (k - 2)])
    return slaves, np.repeat(masters[np.newaxis], 5, axis=0)
