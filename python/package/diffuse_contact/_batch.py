"""Many elements at once."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _native
from ._arrays import Floats, check_overlap, choice, dimensions, flag, floats, is_writable, new, word
from ._arrays import count as number_of
from ._errors import ElementError, InputError

Mode = Literal["value", "gradient", "hessian"]
Weight = Literal["cubic", "cubic-interpolating", "wendland-c2"]
Basis = Literal["quadratic", "linear"]
FrameDerivative = Literal["co-moving", "held"]

#: What the numbers in :attr:`GapBatch.status` mean: ``STATUS_CODES[0]`` is ``"ok"``, others are codes of errors.
STATUS_CODES: tuple[str, ...] = tuple(_native.STATUS_CODES)

_MODES = ("value", "gradient", "hessian")


@dataclass(frozen=True)
class GapBatch:
    """Results of k elements with n masters each. All but ``status`` are NaN where there is no result.

    Attributes:
        gap: g, shape (k,), length; positive apart, negative penetrating.
        foot: foot point on the smooth surface, shape (k, 3).
        normal: unit normal of the surface at the foot, towards the outward side, shape (k, 3).
        gradient: N = ∂g/∂x, shape (k, 3(n+1)), coordinates ordered slave, master 1, …, master n; (k, 0) below
            gradient mode.
        hessian: M = ∂²g/∂x∂x, 1/length; shape (k, 3(n+1), 3(n+1)), or packed (k, 3(n+1)(3n+4)/2): the lower
            triangle row by row, entry (i, j ≤ i) at i(i+1)/2 + j. Without entries below Hessian mode.
        status: shape (k,); 0 if there is a result, else the place of the error's code in ``STATUS_CODES``.

    """

    gap: Floats
    foot: Floats
    normal: Floats
    gradient: Floats
    hessian: Floats
    status: NDArray[np.uint8]

    @property
    def ok(self) -> NDArray[np.bool_]:
        """Which elements have a result, shape (k,)."""
        return self.status == 0

    def codes(self) -> list[str]:
        """The word for every element: ``"ok"`` or the code of its error."""
        return [STATUS_CODES[status] if status < len(STATUS_CODES) else "other" for status in self.status]

    @staticmethod
    def empty(count: int, masters: int, mode: Mode = "hessian", *, packed: bool = False) -> GapBatch:
        """Arrays for the results of ``count`` elements with ``masters`` masters each, to be handed to ``gap``."""
        count, masters = number_of("count", count), number_of("masters", masters)
        shapes = _shapes(count, masters, choice("mode", mode, *_MODES), flag("packed", packed))
        arrays = {name: new(name, shape) for name, shape in shapes.items()}
        return GapBatch(**arrays, status=np.zeros(count, dtype=np.uint8))


def _shapes(count: int, masters: int, mode: str, packed: bool) -> dict[str, tuple[int, ...]]:
    freedoms = 3 * (masters + 1)
    hessian = (freedoms * (freedoms + 1) // 2,) if packed else (freedoms, freedoms)
    return {
        "gap": (count,),
        "foot": (count, 3),
        "normal": (count, 3),
        "gradient": (count, freedoms if mode != "value" else 0),
        "hessian": (count, *(hessian if mode == "hessian" else (0,) * len(hessian))),
    }


def _check_out(out: GapBatch, shapes: dict[str, tuple[int, ...]], count: int) -> None:
    if not isinstance(out, GapBatch):
        raise InputError(f"out has to be a GapBatch, not {type(out).__name__}", "wrong-type")
    for name, shape in {**shapes, "status": (count,)}.items():
        array = getattr(out, name)
        dtype = np.uint8 if name == "status" else np.float64
        if not (is_writable(array, dtype) and array.shape == shape):
            raise InputError(
                f"out.{name} has to be a writable, aligned {np.dtype(dtype)} array of shape {shape} in C order",
                "wrong-shape",
            )


def _one_or_each(what: str, values: ArrayLike, count: int, *shape: int) -> Floats:
    """One value for all elements, or one for each, with a leading axis of length 1 or ``count``."""
    if dimensions(what, values) == len(shape):
        return floats(what, values, *shape)[np.newaxis]
    return floats(what, values, count, *shape)


def gap(
    slaves: ArrayLike,
    masters: ArrayLike,
    outward: ArrayLike | None = None,
    *,
    frames: ArrayLike | None = None,
    support_radius: ArrayLike | None = None,
    basis: Basis | None = None,
    weight: Weight = "cubic",
    frame_derivative: FrameDerivative | None = None,
    mode: Mode = "hessian",
    packed: bool = False,
    on_error: Literal["raise", "status"] = "raise",
    out: GapBatch | None = None,
) -> GapBatch:
    """Gap, foot, normal, N and M of k diffuse elements with n masters each.

    Lengths are in the unit of the coordinates. Elements are evaluated without the GIL, in parallel, side by side in
    the machine's vectors; what an element gets depends neither on the others nor on the number of threads. Arrays of
    float64 in C order are read where they are: no other thread should write to them meanwhile.

    Args:
        slaves: slave nodes, shape (k, 3).
        masters: master nodes, shape (k, n, 3).
        outward: a direction to the outward side of the master surface, of any length, shape (3,) for all elements
            or (k, 3). Needed for average planes; with given frames it turns their normals.
        frames: local frames, rows t1, t2 and the outward unit normal, shape (3, 3) or (k, 3, 3); if left out, the
            average planes of the masters.
        support_radius: radius of the domain of influence, a number or shape (k,); if left out, 1.25 times the
            farthest in-plane distance of a master from the slave.
        basis: ``"quadratic"`` (from six masters on) or ``"linear"`` (from three); if left out, quadratic from six
            masters on.
        weight: ``"cubic"``, ``"cubic-interpolating"`` (the surface passes through the masters) or
            ``"wendland-c2"``.
        frame_derivative: ``"co-moving"``, the average plane moves with the masters while differentiating, or
            ``"held"``; co-moving if left out, but held with given frames.
        mode: ``"value"``, ``"gradient"`` (N too) or ``"hessian"`` (N and M too).
        packed: whether M is given as its packed lower triangle.
        on_error: ``"raise"`` an ElementError for the first element without a result, or tell it in ``status``.
        out: arrays to write to, see ``GapBatch.empty``. They spare the memory of new ones; on an error they hold
            anything.

    Raises:
        InputError: for a wrong shape, type or name, and for ``out`` that shares memory with another array.
        ElementError: if an element has no result and ``on_error`` is ``"raise"``; its ``index`` says which one.
        BusyError: if another thread's call has an array of this one, and one of the two writes to it.

    Example:
        >>> import numpy as np
        >>> grid = np.arange(9)
        >>> masters = np.column_stack([grid % 3 - 1.0, grid // 3 - 1.0, np.zeros(9)])
        >>> slaves = np.array([[0.1, 0.2, 0.25], [0.1, 0.2, -0.125]])
        >>> result = gap(slaves, np.stack([masters, masters]), outward=[0, 0, 1], mode="gradient")
        >>> np.round(result.gap, 12).tolist(), result.gradient.shape
        ([0.25, -0.125], (2, 30))

    """
    choice("on_error", on_error, "raise", "status")
    slaves = floats("slaves", slaves, "k", 3)
    count = len(slaves)
    masters = floats("masters", masters, count, "n", 3)
    nodes = masters.shape[1]
    if frames is not None:
        frames = _one_or_each("frames", frames, count, 3, 3)
        if frame_derivative is not None and word("frame_derivative", frame_derivative) == "co-moving":
            raise InputError(
                'frame_derivative cannot be "co-moving" with given frames, which do not move with the masters',
                "co-moving-given-frame",
            )
    elif outward is None:
        raise InputError("outward is missing: it tells which side of the average plane is outside", "missing-outward")
    outward = np.empty((0, 3)) if outward is None else _one_or_each("outward", outward, count, 3)
    if support_radius is not None:
        support_radius = _one_or_each("support_radius", support_radius, count)
    if basis is None:
        basis = "quadratic" if nodes >= 6 else "linear"
    if frame_derivative is None:
        frame_derivative = "co-moving" if frames is None else "held"
    choice("mode", mode, *_MODES)
    packed = flag("packed", packed)
    shapes = _shapes(count, nodes, mode, packed)
    if out is None:
        out = GapBatch.empty(count, nodes, mode, packed=packed)
    else:
        _check_out(out, shapes, count)
        read = {"slaves": slaves, "masters": masters, "outward": outward, "frames": frames}
        read["support_radius"] = support_radius
        check_overlap(read, {f"out.{name}": getattr(out, name) for name in (*shapes, "status")})
    inputs = SimpleNamespace(
        slaves=slaves,
        masters=masters,
        outward=outward,
        frames=frames,
        support_radius=support_radius,
        basis=word("basis", basis),
        weight=word("weight", weight),
        frame_derivative=word("frame_derivative", frame_derivative),
    )
    outputs = SimpleNamespace(
        gap=out.gap,
        foot=out.foot,
        normal=out.normal,
        gradient=out.gradient.reshape(-1),
        hessian=out.hessian.reshape(-1),
        status=out.status,
    )
    failed = _native.gap_batch(inputs, outputs, mode, packed)
    if failed is not None and on_error == "raise":
        index, code, message = failed
        raise ElementError(f"element {index}: {message}", code, index)
    return out
