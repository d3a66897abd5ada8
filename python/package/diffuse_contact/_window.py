"""Windows of a surface: what some slaves can need of it, where nobody holds the whole."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._arrays import Floats, Ints, count, dimensions, floats, ints, number
from ._errors import InputError


class Window:
    """What slaves in some boxes can need of a master surface, by the numbers of the whole.

    ``SurfacePart.window`` and ``ContactInterface.window`` make windows, ``joined`` makes one of those that come from
    several ranks. It can be pickled; ``numbers`` are two arrays for MPI, and ``Window(*numbers)`` is the same window
    again. Two windows are equal if all their numbers are.

    Args:
        integers: as of ``numbers``.
        reals: as of ``numbers``.

    Raises:
        InterfaceError: ``"invalid-window"`` for numbers that are none of a window, ``"invalid-box"``.

    """

    def __init__(self, integers: ArrayLike, reals: ArrayLike) -> None:
        self._window = _native.Window(ints("integers", integers, "i"), floats("reals", reals, "r"))

    @classmethod
    def _of(cls, window: _native.Window) -> Window:
        made = cls.__new__(cls)
        made._window = window
        return made

    @classmethod
    def joined(cls, windows: Iterable[Window]) -> Window:
        """Windows of the same boxes from the owners of several parts of the surface, as one.

        Raises:
            InterfaceError: ``"different-windows"`` for those of different surfaces, options, boxes or skins;
                ``"invalid-window"`` for none.

        """
        return cls._of(_native.Window.joined([_checked(window) for window in windows]))

    @property
    def numbers(self) -> tuple[Ints, Floats]:
        """Integers, shape (i,), and reals, shape (r,): about 130 bytes a node and 310 a facet that slaves may touch."""
        return self._window.numbers()

    @property
    def nodes(self) -> Ints:
        """Numbers of its nodes in the whole surface, ascending, shape (n,)."""
        return self._window.nodes()

    @property
    def facets(self) -> Ints:
        """Numbers of its facets in the whole surface, ascending, shape (m,)."""
        return self._window.facets()

    @property
    def boxes(self) -> Floats:
        """Its boxes, lowest and highest corner, shape (b, 2, 3), length."""
        return self._window.boxes().reshape(-1, 2, 3)

    @property
    def skin(self) -> float:
        """How far nodes of the surface may move before it is to be made anew, length."""
        return self._window.skin

    @property
    def first_positions(self) -> Floats:
        """First positions of its nodes, shape (n, 3), length."""
        return self._window.first_positions().reshape(-1, 3)

    def __eq__(self, other: object) -> bool:
        return self._window.equals(other._window) if isinstance(other, Window) else NotImplemented

    # Comparing numbers is not what a dictionary should do.
    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[type[Window], tuple[Ints, Floats]]:
        return Window, self.numbers

    def __repr__(self) -> str:
        return f"<Window of {len(self.nodes)} nodes, {len(self.facets)} facets, {len(self.boxes)} boxes>"


def _checked(window: Any) -> _native.Window:
    if not isinstance(window, Window):
        raise InputError(f"a Window is needed, not {type(window).__name__}", "wrong-type")
    return window._window


def _boxes(boxes: ArrayLike) -> Floats:
    if dimensions("boxes", boxes) > 0 and np.size(boxes) == 0:
        return np.empty((0, 3))
    return floats("boxes", boxes, "b", 2, 3).reshape(-1, 3)


def boxes_around(points: ArrayLike, reach: float, most: int = 16) -> Floats:
    """Boxes around groups of points, shape (b, 2, 3) with b ≤ ``most``, for windows.

    Args:
        points: shape (k, 3), length; those that are not finite belong to no box.
        reach: how far beyond each point a box reaches, length: the limit of the distance, and what slaves move until
            the next window; finite, at least 0.
        most: the largest number of boxes.

    """
    points = floats("points", points, "k", 3)
    reach = number("reach", reach)
    if not 0 <= reach < math.inf:
        raise InputError(f"reach has to be finite and at least 0, not {reach}", "invalid-option")
    return _native.boxes_around(points, reach, count("most", most)).reshape(-1, 2, 3)


def split_history(history: ArrayLike) -> list[Floats]:
    """The numbers of each slave in a ``ContactInterface.history``; one after another they are the history again.

    So histories go with slaves from one interface to another. They name nodes by their numbers in the whole surface.

    Raises:
        InterfaceError: ``"invalid-history"``.

    """
    numbers = floats("history", history, "h")
    return np.split(numbers, np.cumsum(_native.history_lengths(numbers)))[:-1]
