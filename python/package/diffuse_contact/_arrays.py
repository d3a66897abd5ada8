"""What people pass, as the contiguous arrays that the compiled part takes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Facets = ArrayLike | Sequence[Sequence[int]]


def _array(what: str, values: Any) -> NDArray[Any]:
    try:
        return np.asarray(values)
    except ValueError as error:
        raise InputError(f"{what}: the rows have different lengths ({error})", "wrong-shape") from None


def _check_shape(what: str, found: tuple[int, ...], shape: tuple[int | str, ...]) -> None:
    fits = len(found) == len(shape) and all(
        isinstance(wanted, str) or size == wanted for size, wanted in zip(found, shape, strict=True)
    )
    if not fits:
        wanted = ", ".join(str(size) for size in shape)
        raise InputError(f"{what}: the shape has to be ({wanted}), not {found}", "wrong-shape")


def floats(what: str, values: Any, *shape: int | str) -> Floats:
    """``values`` as float64 in C order; a copy only if they are anything else. A word in the shape is any length."""
    array = _array(what, values)
    if array.dtype.kind not in "fiu":
        raise InputError(f"{what}: real numbers are needed, not {array.dtype}", "wrong-type")
    _check_shape(what, array.shape, shape)
    return np.asarray(array, dtype=np.float64, order="C")


def ints(what: str, values: Any, *shape: int | str) -> Ints:
    """``values`` as int64 in C order; they have to be integers."""
    array = _array(what, values)
    if array.size == 0 and array.dtype.kind == "f":
        array = array.astype(np.int64)
    if array.dtype.kind not in "iu":
        raise InputError(f"{what}: integers are needed, not {array.dtype}", "wrong-type")
    _check_shape(what, array.shape, shape)
    if array.dtype == np.uint64 and array.size and int(array.max()) > np.iinfo(np.int64).max:
        raise InputError(f"{what}: {int(array.max())} is more than an index can be", "wrong-type")
    return np.asarray(array, dtype=np.int64, order="C")


def facets(what: str, values: Facets) -> Ints:
    """Facets as rows of four, the last one −1 for triangles."""
    if not isinstance(values, np.ndarray):
        rows = list(values)  # type: ignore[arg-type]
        if len({len(row) for row in rows if hasattr(row, "__len__")}) > 1:
            values = [_padded(what, row) for row in rows]
        else:
            values = rows
    array = ints(what, values) if np.ndim(values) == 0 else _array(what, values)
    if array.size == 0:
        return np.empty((0, 4), dtype=np.int64)
    if array.ndim != 2 or array.shape[1] not in (3, 4):
        raise InputError(f"{what}: the shape has to be (m, 3) or (m, 4), not {array.shape}", "wrong-shape")
    array = ints(what, array, "m", array.shape[1])
    if array.shape[1] == 3:
        array = np.column_stack([array, np.full(len(array), -1, dtype=np.int64)])
    return np.ascontiguousarray(array)


def _padded(what: str, row: Sequence[int]) -> list[int]:
    corners = list(row)
    if len(corners) not in (3, 4):
        raise InputError(f"{what}: a facet has 3 or 4 corners, not {len(corners)}", "facet-corners")
    return corners if len(corners) == 4 else [*corners, -1]


def count(what: str, value: Any, least: int = 0) -> int:
    """A whole number."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | np.integer):
        raise InputError(f"{what} has to be an integer, not {value!r}", "wrong-type")
    if value < least:
        raise InputError(f"{what} has to be at least {least}, not {value}", "invalid-option")
    return int(value)


def number(what: str, value: Any) -> float:
    """A real number."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.integer | np.floating):
        raise InputError(f"{what} has to be a number, not {value!r}", "wrong-type")
    return float(value)


def word(what: str, value: Any) -> str:
    """A name; which one is for the compiled part to judge."""
    if not isinstance(value, str):
        raise InputError(f"{what} has to be a word, not {value!r}", "wrong-type")
    return value
