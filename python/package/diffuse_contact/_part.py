"""Parts of a surface, from which windows are cut where nobody holds the whole."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import Facets, Floats, Ints, Planes, bools, facets, flags, floats, ints, number, planes
from ._errors import InputError
from ._interface import Options, _named_options
from ._window import Window, _boxes


@dataclass(frozen=True)
class Extents:
    """How large a surface is in its first configuration. Those of all parts joined, in any order, are of the whole.

    Attributes:
        low: lowest coordinates of a node, length.
        high: highest coordinates, length.
        facet: longest edge of a facet, length.

    """

    low: tuple[float, float, float]
    high: tuple[float, float, float]
    facet: float

    @staticmethod
    def of(positions: ArrayLike, corners: Facets) -> Extents:
        """Of facets, as for ``MasterSurface``. Those of none change no others that they are joined with.

        Raises:
            SurfaceError: for facets that are none, each by itself.

        """
        arrays = floats("positions", positions, "p", 3), facets("facets", corners)
        (a, b, c), (d, e, f), facet = _native.extents(*arrays)
        return Extents((a, b, c), (d, e, f), facet)

    def joined(self, other: Extents) -> Extents:
        """Those of two parts together."""
        low, high = np.minimum(self.low, other.low).tolist(), np.maximum(self.high, other.high).tolist()
        return Extents(tuple(low), tuple(high), max(self.facet, other.facet))

    def _row(self) -> tuple[list[float], list[float], float]:
        low, high = (floats(f"extents.{name}", getattr(self, name), 3).tolist() for name in ("low", "high"))
        return low, high, number("extents.facet", self.facet)


@dataclass(frozen=True, eq=False)
class PartDemands:
    """What the fits at the facets of a part ask of domains. Other parts with the same nodes and facets have to know.

    Plain arrays, to be sent. Two rounds of them settle the domains.

    Attributes:
        nodes: numbers of nodes in the whole surface, ascending, each as often as sheets meet in it, shape (n,).
        factors: by how much their domains have to be larger, shape (n,): the largest of all parts counts. In the second
            round by how much they may shrink.
        crowded: in the second round whether a domain shrinks at all, uint8, shape (n,): it does if any part says 1.
        facets: numbers of the facets whose fits do not carry the quadratic basis, ascending, shape (m,).
        bases: what they carry, uint8, shape (m,): 1 for the linear basis, 0 for nothing. The least of all parts counts.

    """

    nodes: Ints
    factors: Floats
    crowded: NDArray[np.uint8]
    facets: Ints
    bases: NDArray[np.uint8]

    def _row(self) -> tuple[Ints, Floats, NDArray[np.uint8], Ints, NDArray[np.uint8]]:
        nodes, rows = ints("nodes", self.nodes, "n"), ints("facets", self.facets, "m")
        crowded, bases = flags("crowded", self.crowded, len(nodes)), flags("bases", self.bases, len(rows))
        return nodes, floats("factors", self.factors, len(nodes)), crowded, rows, bases


class SurfacePart:
    """The facets that a rank owns and those around them: windows are cut out of it.

    Made once, in the first positions. Its ``demands`` go to the ranks whose known boxes meet its own, and ``settle``
    takes over theirs, until it says True. From then on ``window`` tells what another rank's slaves can need of the own
    facets.

    Args:
        positions: first positions of the nodes, shape (p, 3), length.
        corners: facets, as for ``MasterSurface``, by place among the positions.
        node_numbers: numbers of the nodes in the whole surface, shape (p,), each once, in any order, below 2⁵³.
        facet_numbers: numbers of the facets in the whole surface, shape (m,), each once, in any order.
        owned: which of the facets the rank owns, bool, shape (m,). Each facet of the whole surface has one owner.
        known: a box, lowest and highest corner, shape (2, 3): everything of the whole surface that meets it is here.
        extents: those of the whole surface.
        symmetry: planes of symmetry, as for ``ContactInterface``.
        options: the fields of ``Options``, by keyword; ``weight``, ``basis`` and ``feature_angle`` count.

    Raises:
        InterfaceError: ``"part-too-narrow"`` if the fits of an own facet may depend on what does not meet the known
            box, ``"invalid-window"`` for numbers that are none, ``"invalid-extents"`` for extents that are not finite
            or do not hold the own facets, ``"window-needs-domains"``, ``"invalid-box"``; for facets that are no
            surface, and for planes.
        InputError: for a wrong shape, type or name.

    """

    def __init__(
        self,
        positions: ArrayLike,
        corners: Facets,
        *,
        node_numbers: ArrayLike,
        facet_numbers: ArrayLike,
        owned: ArrayLike,
        known: ArrayLike,
        extents: Extents,
        symmetry: Planes = (),
        **options: Any,
    ) -> None:
        self._options = _named_options(SurfacePart, options)
        if not isinstance(extents, Extents):
            raise InputError(f"extents have to be Extents, not {type(extents).__name__}", "wrong-type")
        self._part = _native.Part(
            floats("positions", positions, "p", 3),
            ints("node_numbers", node_numbers, "p"),
            facets("facets", corners),
            ints("facet_numbers", facet_numbers, "m"),
            bools("owned", owned),
            floats("known", known, 2, 3).tolist(),
            extents._row(),
            self._options,
            planes("symmetry", symmetry),
        )

    @property
    def options(self) -> Options:
        """The options."""
        return self._options

    @property
    def demands(self) -> PartDemands:
        """What other parts have to know in this round of nodes and facets of this part, which may be theirs, too."""
        return PartDemands(*self._part.demands())

    def settle(self, others: Iterable[PartDemands]) -> bool:
        """Takes over what other parts ask for, all those whose known boxes meet that of this one.

        What concerns nodes and facets that are not here is left out. Returns whether domains are settled. If not, the
        ``demands`` are those of the next round: exchange them, and call this once more. All parts take the same number
        of rounds.

        Raises:
            InterfaceError: ``"part-too-narrow"`` if what concerns an own facet may depend on what is not here.

        """
        return self._part.settle([own._row() for own in others])

    def window(self, positions: ArrayLike, boxes: ArrayLike, skin: float) -> Window:
        """What slaves in boxes can need of the own facets.

        Args:
            positions: of all nodes of the part, shape (p, 3); those that are no corners of own facets are not looked
                at.
            boxes: lowest and highest corners, shape (b, 2, 3). See ``boxes_around``.
            skin: how far nodes of the surface may move before a new window is to be made, length.

        Raises:
            InterfaceError: ``"invalid-box"``; ``"invalid-window"`` before ``settle``; for another number of positions.

        """
        positions = floats("positions", positions, "p", 3)
        return Window._of(self._part.window(positions, _boxes(boxes), number("skin", skin)))
