"""The master surface, and the areas of slave nodes."""

from __future__ import annotations

from typing import NoReturn

from numpy.typing import ArrayLike

from . import _native
from ._arrays import Facets, Floats, Ints, facets, floats


class MasterSurface:
    """The connectivity of the master facets, checked once: triangles and bilinear quadrilaterals.

    Args:
        positions: positions of all nodes, shape (p, 3), length.
        corners: facets, node indices counter-clockwise seen from outside; an array of shape (m, 3) or (m, 4), in which
            −1 for the fourth corner makes a triangle, or a list of lists of three and four.

    It cannot be pickled or copied (``TypeError``), since it does not keep the positions it was checked at.

    Raises:
        SurfaceError: if that is no oriented surface: a corner out of range, a node twice in a facet, a facet without
            area, a quadrilateral that is not convex, more than two facets at an edge, a flipped facet.
        InputError: for a wrong shape or type.

    """

    def __init__(self, positions: ArrayLike, corners: Facets) -> None:
        # The caller's array is the caller's.
        self._facets = facets("facets", corners).copy()
        self._surface = _native.Surface(floats("positions", positions, "p", 3), self._facets)

    @property
    def facets(self) -> Ints:
        """The facets, shape (m, 4); the last corner of a triangle is −1."""
        return self._facets.copy()

    @property
    def nodes(self) -> Ints:
        """The nodes of the surface, ascending."""
        return self._surface.nodes()

    @property
    def border_edges(self) -> Ints:
        """The edges that belong to one facet only, as it runs through them, shape (e, 2)."""
        return self._surface.border_edges().reshape(-1, 2)

    def node_normals(self, positions: ArrayLike) -> Floats:
        """Outward normals of ``nodes``: sums of the area vectors of the facets at each, not normalised, length²."""
        return self._surface.node_normals(floats("positions", positions, "p", 3)).reshape(-1, 3)

    def __reduce__(self) -> NoReturn:
        # It was checked at positions that it does not keep.
        raise TypeError(
            "a MasterSurface cannot be pickled or copied: send positions and facets, and make one in each process"
        )

    def __repr__(self) -> str:
        return f"<MasterSurface of {self._surface.facet_count} facets, {len(self.nodes)} nodes>"


def tributary_areas(positions: ArrayLike, corners: Facets) -> Floats:
    """Tributary area of every node, shape (p,), length²: the integral of its shape function over the facets at it.

    Args:
        positions: positions of all nodes, shape (p, 3).
        corners: facets, as for ``MasterSurface``.

    Raises:
        SurfaceError: for facets that are none.

    """
    return _native.tributary_areas(floats("positions", positions, "p", 3), facets("facets", corners))
