"""What people pass, as the contiguous arrays that the compiled part takes."""

from __future__ import annotations

import itertools
import reprlib
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Indices = NDArray[np.int32] | NDArray[np.int64]
Facets = ArrayLike | Sequence[Sequence[int]]
Planes = ArrayLike | Sequence[tuple[ArrayLike, ArrayLike]]


def _array(what: str, values: Any) -> NDArray[Any]:
    if np.ma.isMaskedArray(values) and np.ma.is_masked(values):
        raise InputError(f"{what}: entries are masked, and there is nothing to read in their place", "wrong-type")
    try:
        return np.asarray(values)
    except (ValueError, TypeError, OverflowError) as error:
        raise InputError(f"{what}: the rows make no array ({error})", "wrong-shape") from None


def dimensions(what: str, values: Any) -> int:
    """Number of axes."""
    return _array(what, values).ndim


def _sound(array: NDArray[Any], dtype: Any) -> NDArray[Any]:
    """In C order, native byte order and aligned; a copy only if it is not."""
    array = np.asarray(array, dtype=dtype, order="C")
    return array if array.flags.aligned else array.copy()


def new(what: str, shape: int | tuple[int, ...]) -> Floats:
    """An array whose contents are still to be set."""
    try:
        return np.empty(shape)
    except (MemoryError, ValueError, OverflowError):
        raise InputError(f"{what}: there is no room for an array of shape {shape}", "too-large") from None


def is_writable(array: Any, dtype: Any) -> bool:
    """Whether an array can be written to where it is."""
    return (
        isinstance(array, np.ndarray)
        and array.dtype == dtype
        and array.flags.c_contiguous
        and array.flags.aligned
        and array.flags.writeable
    )


def vector(what: str, out: Any) -> Floats:
    """A vector to be written to where it is."""
    if not (is_writable(out, np.float64) and out.ndim == 1):
        raise InputError(f"{what} has to be a writable, aligned float64 vector in C order", "wrong-array")
    return out


def bools(what: str, values: Any) -> NDArray[np.bool_]:
    """``values`` as a vector of bool."""
    array = _array(what, values)
    if array.dtype != np.bool_:
        raise InputError(f"{what}: True and False are needed, not {array.dtype}", "wrong-type")
    _check_shape(what, array.shape, ("s",))
    return _sound(array, np.bool_)


def check_overlap(read: dict[str, Any], written: dict[str, Any]) -> None:
    """Refuses an array that is written and shares memory with another one of the call.

    The compiled part knows arrays by the object that their memory belongs to. Of one buffer there may be several.
    """
    arrays = [(name, array, False) for name, array in read.items() if array is not None]
    arrays += [(name, array, True) for name, array in written.items()]
    for (one, a, _), (other, b, is_written) in itertools.combinations(arrays, 2):
        if is_written and np.may_share_memory(a, b):
            raise InputError(f"{one} and {other} share memory, and one of them is written", "overlap")


def flags(what: str, values: Any, *shape: int | str) -> NDArray[np.uint8]:
    """``values`` as uint8; they have to be 0 or 1."""
    array = ints(what, values, *shape)
    wrong = array[(array < 0) | (array > 1)]
    if wrong.size:
        raise InputError(f"{what}: 0 and 1 are needed, not {wrong[0]}", "invalid-option")
    return array.astype(np.uint8)


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
    return _sound(array, np.float64)


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
    return _sound(array, np.int64)


def facets(what: str, values: Facets) -> Ints:
    """Facets as rows of four, the last one −1 for triangles."""
    rows: Any = values
    if not isinstance(values, np.ndarray):
        try:
            rows = list(rows)
            if len({len(row) for row in rows if hasattr(row, "__len__")}) > 1:
                rows = [_padded(what, row) for row in rows]
        except TypeError as error:
            raise InputError(f"{what}: rows of three or four nodes are needed ({error})", "wrong-shape") from None
    array = _array(what, rows)
    if array.size == 0:
        return np.empty((0, 4), dtype=np.int64)
    if array.ndim != 2 or array.shape[1] not in (3, 4):
        raise InputError(f"{what}: the shape has to be (m, 3) or (m, 4), not {array.shape}", "wrong-shape")
    array = ints(what, array, "m", array.shape[1])
    if array.shape[1] == 3:
        array = np.column_stack([array, np.full(len(array), -1, dtype=np.int64)])
    return np.ascontiguousarray(array)


def quadratic(what: str, values: Any) -> list[Ints]:
    """Faces of second order: one array of shape (f, 6), (f, 8) or (f, 9), or several."""
    try:
        is_one = isinstance(values, np.ndarray) or (len(values) > 0 and dimensions(what, values[0]) == 1)
        arrays = [values] if is_one else list(values)
    except TypeError as error:
        raise InputError(f"{what}: faces are arrays of nodes ({error})", "wrong-shape") from None
    faces = [_array(what, array) for array in arrays]
    for array in faces:
        if array.ndim != 2 or array.shape[1] not in (6, 8, 9):
            raise InputError(f"{what}: the shape has to be (f, 6), (f, 8) or (f, 9), not {array.shape}", "wrong-shape")
    return [ints(what, array, "f", array.shape[1]) for array in faces]


def _padded(what: str, row: Sequence[int]) -> list[int]:
    corners = list(row)
    if len(corners) not in (3, 4):
        raise InputError(f"{what}: a facet has 3 or 4 corners, not {len(corners)}", "facet-corners")
    return corners if len(corners) == 4 else [*corners, -1]


def count(what: str, value: Any, least: int = 0) -> int:
    """A whole number."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | np.integer):
        raise InputError(f"{what} has to be an integer, not {shown(value)}", "wrong-type")
    whole = int(value)
    if whole < least:
        raise InputError(f"{what} has to be at least {least}, not {shown(whole)}", "invalid-option")
    if whole > sys.maxsize:
        raise InputError(f"{what} cannot be {shown(whole)}", "invalid-option")
    return whole


def shown(value: Any) -> str:
    """A value as a sentence may show it: numbers may have any number of digits, and objects no text at all."""
    if isinstance(value, int) and abs(value) > sys.maxsize:
        return f"an integer of {value.bit_length()} bits"
    try:
        return reprlib.repr(value)
    except Exception:
        return f"an object of type {type(value).__name__}"


def number(what: str, value: Any) -> float:
    """A real number."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, int | float | np.integer | np.floating):
        raise InputError(f"{what} has to be a number, not {shown(value)}", "wrong-type")
    try:
        return float(value)
    except OverflowError:
        raise InputError(f"{what} cannot be {shown(value)}", "invalid-option") from None


def word(what: str, value: Any) -> str:
    """A name; which one is for the compiled part to judge."""
    if not isinstance(value, str):
        raise InputError(f"{what} has to be a word, not {shown(value)}", "wrong-type")
    if not value.isascii():
        raise InputError(f"{what} cannot be {value!a}", "invalid-option")
    return value


def choice(what: str, value: Any, *words: str) -> str:
    """One of these words."""
    if word(what, value) not in words:
        raise InputError(f"{what} has to be one of {', '.join(map(repr, words))}, not {shown(value)}", "invalid-option")
    return str(value)


def flag(what: str, value: Any) -> bool:
    """True or False."""
    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{what} has to be True or False, not {shown(value)}", "wrong-type")
    return bool(value)


def planes(what: str, values: Planes) -> Floats:
    """Points and normals of planes in turn, shape (2m, 3)."""
    array = _array(what, values)
    if array.size == 0 and array.ndim < 3:
        return np.empty((0, 3))
    return floats(what, array, "m", 2, 3).reshape(-1, 3)
