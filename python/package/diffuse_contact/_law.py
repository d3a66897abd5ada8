"""Laws of contact."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from . import _native
from ._arrays import Floats, flag, floats, number, word
from ._errors import InputError

Tangent = Literal["exact", "gauss-newton"]


def _own(what: str, values: Any, *shape: int | str) -> Floats:
    """A copy that nobody writes to."""
    array = floats(what, values, *shape).copy()
    array.setflags(write=False)
    return array


@dataclass(frozen=True, eq=False)
class TabulatedPressure:
    """A normal law by table: linear between its gaps, and beyond them along its outer lines.

    A contact whose pressure is not positive is open. Over nodes without areas it is a force. Friction of a contact that
    closes in an increment counts from the gap at which the last falling line has no pressure any more.

    Attributes:
        gaps: ascending, at least two, shape (t,), length.
        pressures: at these gaps, shape (t,), force per area.

    Raises:
        AssemblyError: ``"invalid-table"`` with the place of the first entry that is not finite or does not ascend.

    """

    gaps: ArrayLike
    pressures: ArrayLike

    def __post_init__(self) -> None:
        for name in ("gaps", "pressures"):
            object.__setattr__(self, name, _own(name, getattr(self, name), "t"))
        _native.check_law(law_of(1.0, None, normal=self))


@dataclass(frozen=True)
class DecayingCoefficient:
    """A coefficient of friction that decays from rest to fast sliding, μ = μ_k + (μ_s − μ_k) exp(−β v).

    Attributes:
        at_rest: μ_s ≥ 0.
        in_motion: μ_k ≥ 0.
        decay: β ≥ 0, time per length.

    """

    at_rest: float
    in_motion: float
    decay: float

    def __post_init__(self) -> None:
        for name in ("at_rest", "in_motion", "decay"):
            object.__setattr__(self, name, number(name, getattr(self, name)))


@dataclass(frozen=True, eq=False)
class TabulatedCoefficient:
    """A coefficient of friction by pressure and slip rate: bilinear in its table, constant beyond it.

    Attributes:
        pressures: ascending, shape (p,), force per area; one number if the coefficient does not depend on it.
        rates: ascending, shape (r,), length per time; one number if the coefficient does not depend on it.
        coefficients: μ ≥ 0, shape (p, r).

    """

    pressures: ArrayLike
    rates: ArrayLike
    coefficients: ArrayLike

    def __post_init__(self) -> None:
        pressures, rates = _own("pressures", self.pressures, "p"), _own("rates", self.rates, "r")
        coefficients = _own("coefficients", self.coefficients, len(pressures), len(rates))
        for name, value in (("pressures", pressures), ("rates", rates), ("coefficients", coefficients)):
            object.__setattr__(self, name, value)


@dataclass(frozen=True)
class Coulomb:
    """Coulomb's friction, wherever ``friction=`` is taken.

    Attributes:
        coefficient: μ, or a law of it by pressure and slip rate, whose derivatives are part of the exact tangent.
        stiffness: of contacts that stick, in the unit of the penalty, which it is by default.
        shear_limit: traction that no contact exceeds, in the unit of the pressure.
        duration: of the increment, time; needed for a coefficient that is a law.
        augmented: whether the history notes where contacts really stuck, so that ``augment`` can take away what they
            creep by the stiffness. Tractions are the same.

    Raises:
        AssemblyError: for a coefficient, a table, a stiffness, a limit or a duration that is none.

    """

    coefficient: float | DecayingCoefficient | TabulatedCoefficient
    stiffness: float | None = None
    shear_limit: float | None = None
    duration: float | None = None
    augmented: bool = False

    def __post_init__(self) -> None:
        if not isinstance(self.coefficient, DecayingCoefficient | TabulatedCoefficient):
            object.__setattr__(self, "coefficient", number("coefficient", self.coefficient))
            if self.duration is not None:
                raise InputError("duration goes with a coefficient that is a law", "invalid-option")
        for name in ("stiffness", "shear_limit", "duration"):
            value = getattr(self, name)
            object.__setattr__(self, name, None if value is None else number(name, value))
        object.__setattr__(self, "augmented", flag("augmented", self.augmented))
        _native.check_law(law_of(1.0, None, friction=self))


Friction = float | Sequence[float] | Coulomb


@dataclass(frozen=True)
class _Friction:
    """As the compiled part takes it."""

    coefficient: float | tuple[float, float, float] | tuple[Floats, Floats, Floats]
    stiffness: float
    shear_limit: float | None
    duration: float | None
    augmented: bool


@dataclass(frozen=True)
class _Law:
    """As the compiled part takes it."""

    penalty: float
    multipliers: Floats | None
    tangent: str
    friction: _Friction | None
    normal: tuple[Any, Any] | None


def _friction(friction: Any, penalty: float) -> _Friction:
    if isinstance(friction, Coulomb):
        law = friction.coefficient
        coefficient: Any = law
        if isinstance(law, DecayingCoefficient):
            coefficient = (law.at_rest, law.in_motion, law.decay)
        elif isinstance(law, TabulatedCoefficient):
            coefficient = (law.pressures, law.rates, np.ravel(law.coefficients))
        stiffness = penalty if friction.stiffness is None else friction.stiffness
        return _Friction(coefficient, stiffness, friction.shear_limit, friction.duration, friction.augmented)
    is_sequence = isinstance(friction, tuple | list) or np.ndim(friction) == 1
    numbers = tuple(friction) if is_sequence else (friction, penalty)
    if len(numbers) not in (2, 3):
        raise InputError(f"friction: a sequence has 2 or 3 numbers, not {len(numbers)}", "wrong-shape")
    coefficient, stiffness, *limit = numbers
    shear_limit = number("shear_limit", limit[0]) if limit else None
    return _Friction(number("friction", coefficient), number("stiffness", stiffness), shear_limit, None, False)


def law_of(
    penalty: float,
    multipliers: ArrayLike | None,
    tangent: str = "exact",
    friction: Friction | None = None,
    normal: TabulatedPressure | None = None,
) -> _Law:
    """What people pass as the compiled part takes it."""
    if multipliers is not None:
        multipliers = floats("multipliers", multipliers, "s")
    penalty = number("penalty", penalty)
    if not (normal is None or isinstance(normal, TabulatedPressure)):
        raise InputError(f"normal has to be a TabulatedPressure, not {type(normal).__name__}", "wrong-type")
    table = None if normal is None else (normal.gaps, normal.pressures)
    sliding = None if friction is None else _friction(friction, penalty)
    return _Law(penalty, multipliers, word("tangent", tangent), sliding, table)
