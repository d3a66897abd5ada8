"""The history of friction, which interfaces over nodes and over faces keep alike."""

from __future__ import annotations

from abc import ABC, abstractmethod

from numpy.typing import ArrayLike

from . import _native
from ._arrays import Floats, bools, floats
from ._law import Friction, TabulatedPressure, law_of
from ._results import FrictionReport


class FrictionHistory(ABC):
    """An interface with a history of friction: of its slaves, or of the nodes of its slave's faces."""

    @property
    @abstractmethod
    def _kept(self) -> _native.Interface | _native.Faces:
        """What keeps the history."""

    def accept(
        self,
        penalty: float,
        *,
        friction: Friction,
        multipliers: ArrayLike | None = None,
        normal: TabulatedPressure | None = None,
    ) -> FrictionReport:
        """Accepts the present positions as the end of an increment: friction of the next one is measured from there.

        To be called once before the first increment, after a refresh, and then after each that has converged. Until
        then nothing of the history changes, so that an increment may be tried again. It ends the evaluation.

        With a coefficient of 0 all slaves slide freely: where there is a history it goes on from their feet, and all
        counts are 0. Without a history nothing happens then. A slave whose outcome is ``"beyond-window"`` keeps its
        history.

        Args:
            penalty: as for the forces.
            friction: as for the forces.
            multipliers: as for the forces: those that the increment was solved with.
            normal: as for the forces.

        Raises:
            InterfaceError: for a penalty or multipliers that are none; ``"not-refreshed"`` before the first refresh.
                Over nodes of the smooth surface ``"no-anchors"`` for other rules than ``"domains"``, and
                ``"no-friction-kernels"`` if the module was built without its feature ``friction``.
            AssemblyError: for a coefficient or a stiffness that is none.

        """
        return FrictionReport(*self._kept.accept(law_of(penalty, multipliers, friction=friction, normal=normal)))

    def augment(
        self,
        penalty: float,
        *,
        friction: Friction,
        multipliers: ArrayLike | None = None,
        normal: TabulatedPressure | None = None,
        moves: ArrayLike | None = None,
    ) -> None:
        """A round of Uzawa's iteration for friction: the traction of each slave that carries force is its multiplier.

        To be called in an equilibrium whose ``slip_errors`` are too large, with the law that it was solved with; then
        evaluate again and find the next equilibrium, which slips less where it sticks. The rounds are part of the
        increment on its way: ``accept`` takes them over, ``roll_back`` forgets them. With a coefficient of 0 nothing
        happens.

        Args:
            penalty: as for the forces.
            friction: a ``Coulomb`` with ``augmented=True``.
            multipliers: as for the forces.
            normal: as for the forces.
            moves: which slaves take part, shape (s,), of bool; all if left out. Where other bodies hold a slave, no
                multiplier can help.

        Raises:
            AssemblyError: for a coefficient or a stiffness that is none.
            InterfaceError: ``"no-augmentation"`` without ``augmented=True``; for a penalty or multipliers that are
                none. Nothing has changed then.

        """
        if moves is not None:
            moves = bools("moves", moves)
        self._kept.augment(law_of(penalty, multipliers, friction=friction, normal=normal), moves)

    def slip_errors(
        self,
        penalty: float,
        *,
        friction: Friction,
        multipliers: ArrayLike | None = None,
        normal: TabulatedPressure | None = None,
    ) -> Floats:
        """How far each slave is from Coulomb's law without the stiffness of stick, shape (s,), length.

        The slip since it stuck where it sticks, and what of it is not along the traction where it slides; 0 without
        force, history or friction. Arguments and exceptions are those of ``augment``.
        """
        return self._kept.slip_errors(law_of(penalty, multipliers, friction=friction, normal=normal))

    def roll_back(self) -> None:
        """Forgets what ``augment`` did since the last accepted increment; it ends the evaluation.

        If that is anything, there is no contact until the next refresh.
        """
        self._kept.roll_back()

    @property
    def history(self) -> Floats:
        """The history of friction as plain numbers, shape (h,), for a restart; empty before the first ``accept``.

        Set it to go on from there, bit for bit. If it is another one, there is no contact until the next refresh.

        Raises:
            InterfaceError: when set, ``"invalid-history"``, ``"anchor-count"``, ``"invalid-opening"`` or
                ``"foreign-carrier"`` for numbers that are no history of this interface.

        """
        return self._kept.history()

    @history.setter
    def history(self, history: ArrayLike) -> None:
        self._kept.set_history(floats("history", history, "h"))

    @property
    def augmented_history(self) -> Floats:
        """What friction is measured from at the moment, shape (h,): the history with the rounds of ``augment`` since.

        Another interface, such as one in a window made anew, goes on from it within the increment.
        """
        return self._kept.augmented_history()
