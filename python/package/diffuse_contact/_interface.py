"""A whole contact interface."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NoReturn

import numpy as np
import scipy.sparse
from numpy.typing import ArrayLike

from . import _native
from ._arrays import (
    Facets,
    Floats,
    Indices,
    Ints,
    Planes,
    check_overlap,
    choice,
    count,
    facets,
    flag,
    floats,
    ints,
    new,
    number,
    planes,
    vector,
    word,
)
from ._batch import Basis, FrameDerivative, Mode, Weight
from ._errors import InputError
from ._history import FrictionHistory
from ._law import Friction, TabulatedPressure, Tangent, law_of
from ._operator import TangentOperator
from ._results import (
    Contact,
    ContactFeet,
    Contacts,
    CutBack,
    GapJump,
    MaterialNodes,
    Pairing,
    RefreshReport,
    SlaveFriction,
    SlaveGap,
    unpacked,
)
from ._surface import MasterSurface
from ._window import Window, _boxes, _checked


@dataclass(frozen=True)
class Options:
    """How an interface pairs and evaluates. Keyword arguments of ``ContactInterface`` are its fields.

    Attributes:
        element: ``"diffuse"``, or ``"node-to-facet"`` for the classic element.
        weight: ``"cubic"``, ``"cubic-interpolating"`` (the surface passes through the masters) or ``"wendland-c2"``.
        frame_derivative: ``"co-moving"``: N and M are exact; ``"held"``: the frame does not move, as in the paper. That
            needs another rule than ``"domains"``.
        rule: which master nodes take part: ``"domains"``, all nodes of the slave's sheet within whose domain of
            influence it lies, so that the gap does not jump; ``"hull-layers"``, ``"hull-radius"`` or ``"nearest"``.
            Domains lie in the first configuration, the positions an interface is made with.
            ``layers`` to ``max_neighbours`` and ``smallest_regularity`` to ``max_candidates`` are for these three.
        layers: hull layers to start with; None for as many as make the fit well conditioned.
        max_layers: hull layers to stop at.
        neighbours: nearest nodes to start with.
        max_neighbours: nearest nodes to stop at.
        basis: ``"quadratic"`` or ``"linear"``.
        linear_fallback: whether the linear basis may stand in where the quadratic one is not carried.
        smallest_regularity: what the regularity of a fit has to exceed, at least 0 and below 1.
        radius_factor: support radius over the in-plane distance of the farthest node, above 1.
        candidates: nearest nodes among which hull layers are sought.
        max_candidates: number up to which ``candidates`` is doubled.
        feature_angle: facets that meet at a larger angle belong to different sheets, degrees.
        border_tolerance: how far beyond the border a foot still counts, in heights of the facet.
        distance_limit: slaves farther away are not paired, length; None for no limit,
            over faces and in self contact for a default of their own.

    """

    element: Literal["diffuse", "node-to-facet"] = "diffuse"
    weight: Weight = "cubic"
    frame_derivative: FrameDerivative = "co-moving"
    rule: Literal["domains", "hull-layers", "hull-radius", "nearest"] = "domains"
    layers: int | None = None
    max_layers: int = 6
    neighbours: int = 12
    max_neighbours: int = 24
    basis: Basis = "quadratic"
    linear_fallback: bool = True
    smallest_regularity: float = 0.01
    radius_factor: float = 1.25
    candidates: int = 48
    max_candidates: int = 192
    feature_angle: float = 45.0
    border_tolerance: float = 0.01
    distance_limit: float | None = None

    def __post_init__(self) -> None:
        for name in ("element", "weight", "frame_derivative", "rule", "basis"):
            word(name, getattr(self, name))
        for name in ("max_layers", "neighbours", "max_neighbours", "candidates", "max_candidates"):
            count(name, getattr(self, name))
        if self.layers is not None:
            count("layers", self.layers)
        for name in ("smallest_regularity", "radius_factor", "feature_angle", "border_tolerance"):
            number(name, getattr(self, name))
        if self.distance_limit is not None:
            number("distance_limit", self.distance_limit)
        object.__setattr__(self, "linear_fallback", flag("linear_fallback", self.linear_fallback))
        _native.check_options(self)


def _options(owner: Callable[..., Any], master: Any, options: dict[str, Any]) -> Options:
    if not isinstance(master, MasterSurface):
        raise InputError(f"master has to be a MasterSurface, not {type(master).__name__}", "wrong-type")
    return _named_options(owner, options)


def _named_options(owner: Callable[..., Any], options: dict[str, Any]) -> Options:
    known = list(Options.__dataclass_fields__)
    for name in options:
        if name not in known:
            # A parameter of the owner may be meant as well.
            parameters = inspect.signature(owner).parameters.values()
            meant = [parameter.name for parameter in parameters if parameter.kind is not parameter.VAR_KEYWORD]
            nearest = difflib.get_close_matches(name, meant + known, n=1)
            suggestion = f" (did you mean {nearest[0]!r}?)" if nearest else ""
            message = f"{owner.__qualname__} has no option {name!r}{suggestion}; the options are {', '.join(known)}"
            raise InputError(message, "unknown-option")
    return Options(**options)


def _equations(dofs: ArrayLike | None, equations: int | None, nodes: int) -> tuple[int, Ints] | None:
    """Number of equations, and those of each node's axes."""
    if dofs is None:
        if equations is not None:
            raise InputError("equations goes with dofs", "invalid-option")
        return None
    numbers = ints("dofs", dofs, nodes, 3)
    if equations is None:
        equations = int(numbers.max(initial=-1)) + 1
    return count("equations", equations), numbers


def adaptive_tangent(residual: float, force: float) -> Tangent:
    """The tangent for the next linear solution of a Newton iteration.

    Far from equilibrium contact forces are those of a trial state, and the exact tangent with them leads nowhere:
    there it is ``"gauss-newton"``, elsewhere ``"exact"``. A tangent is chosen when it is assembled; no evaluation is
    repeated::

        tangent = stiffness + interface.tangent(penalty, tangent=dc.adaptive_tangent(residual_norm, force_norm))

    Args:
        residual: norm of the residual over the free equations, contact included.
        force: the largest norm among external forces, contact forces and reactions, at the same positions.

    Returns:
        ``"exact"`` if residual / force ≤ 0.3 or the residual is 0, else ``"gauss-newton"``; so it is for NaN.

    """
    return _native.adaptive_tangent(number("residual", residual), number("force", force))


class ContactInterface(FrictionHistory):
    """Slave nodes paired with a master surface.

    In a Newton iteration: ``refresh_pairing`` once an increment, then at each iteration ``follow``, ``evaluate``,
    ``forces`` and ``tangent``, the last with ``adaptive_tangent``. Every slave has an outcome; an exception is for
    what the caller has to mend, and leaves the interface as it was. (An evaluation that finds no memory leaves it
    without results.) Arrays given as ``out`` are as they were, but if a sum overflows: they then hold anything.

    Contact force of slave k, with ε_k = penalty × area_k and multiplier λ_k (0 if there are none)::

        f_k = λ_k − ε_k g_k          active if f_k > 0
        R_k = f_k N_k                force on the nodes
        K_k = ε_k N_k N_kᵀ − f_k M_k = −∂R_k/∂x

    so that internal forces minus R are to be balanced, and K is added to the stiffness. The numbers do not depend on
    the number of threads, bit for bit. An interface serves one thread at a time; others get a ``BusyError``. It cannot
    be pickled or copied (``TypeError``): make one in each process.

    Args:
        master: the master surface.
        slaves: slave nodes, shape (s,), each once and none of them on the master.
        positions: positions of all nodes, shape (p, 3), length.
        slave_facets: facets of the slave surface, as for ``MasterSurface``; if given, contacts carry the slaves'
            tributary areas at these positions and the penalty is one per area, else one per node.
        dofs: equations of the nodes' x, y and z, shape (p, 3), −1 where there is none; if left out, 3·node + axis.
        equations: number of equations; if left out, 3p, or the largest of ``dofs`` plus 1.
        symmetry: planes of symmetry, pairs of a point and the unit normal to the side of the model: the master surface
            goes on beyond them as its mirror image. It needs the rule ``"domains"`` or the node-to-facet element.
        options: the fields of ``Options``, by keyword.

    Raises:
        InterfaceError: for slaves, positions or options that are refused, for slave facets and planes of symmetry.
        AssemblyError: for ``dofs`` that name an equation twice or one that does not exist.
        InputError: for a wrong shape, type or name.

    """

    def __init__(
        self,
        master: MasterSurface,
        slaves: ArrayLike,
        positions: ArrayLike,
        *,
        slave_facets: Facets | None = None,
        dofs: ArrayLike | None = None,
        equations: int | None = None,
        symmetry: Planes = (),
        **options: Any,
    ) -> None:
        self._options = _options(ContactInterface, master, options)
        positions = floats("positions", positions, "p", 3)
        numbers = _equations(dofs, equations, len(positions))
        self._interface = _native.Interface(
            master._surface,
            ints("slaves", slaves, "s"),
            positions,
            None if slave_facets is None else facets("slave_facets", slave_facets),
            self._options,
            numbers,
            planes("symmetry", symmetry),
        )

    @classmethod
    def self_contact(
        cls,
        surface: MasterSurface,
        positions: ArrayLike,
        *,
        areas: bool = True,
        dofs: ArrayLike | None = None,
        equations: int | None = None,
        symmetry: Planes = (),
        **options: Any,
    ) -> ContactInterface:
        """An interface of a surface in contact with itself: each of its nodes is a slave.

        The surface may be the skins of several bodies, which then touch one another and themselves. A node may touch
        every facet that faces it, is far along the skin, is not its back and lies in front of it. Both sides push: the
        penalty is half of that between two surfaces.

        Args:
            surface: the surface.
            positions: first positions of all nodes, shape (p, 3), length.
            areas: whether contacts carry the nodes' tributary areas, so that the penalty is one per area. They do by
                default, other than in C.
            dofs: as for ``ContactInterface``.
            equations: as for ``ContactInterface``.
            symmetry: as for ``ContactInterface``.
            options: the fields of ``Options``, by keyword.

        Raises:
            InterfaceError: for positions, options and planes of symmetry that are refused.
            AssemblyError: for ``dofs`` that name an equation twice or one that does not exist.
            InputError: for a wrong shape, type or name.

        """
        made = cls.__new__(cls)
        if not isinstance(surface, MasterSurface):
            raise InputError(f"surface has to be a MasterSurface, not {type(surface).__name__}", "wrong-type")
        made._options = _named_options(cls.self_contact, options)
        positions = floats("positions", positions, "p", 3)
        made._interface = _native.Interface.self_contact(
            surface._surface,
            positions,
            flag("areas", areas),
            made._options,
            _equations(dofs, equations, len(positions)),
            planes("symmetry", symmetry),
        )
        return made

    @classmethod
    def in_window(
        cls,
        window: Window,
        slaves: ArrayLike,
        positions: ArrayLike,
        *,
        slave_facets: Facets | None = None,
        dofs: ArrayLike | None = None,
        equations: int | None = None,
        **options: Any,
    ) -> ContactInterface:
        """An interface of slaves that know a window of the master surface only.

        Results are those of an interface of the whole surface, bit for bit, or a slave has the outcome
        ``"beyond-window"``: a ball that has to be known around it leaves the window's boxes, or the window is older
        than its skin.

        Args:
            window: what is known. Planes of symmetry and first positions are its own.
            slaves: as for ``ContactInterface``.
            positions: first those of ``window.nodes``, in their order and where they were when the window was made;
                those of the slaves come after them.
            slave_facets: all facets at the slaves, in the order of the whole, for the same areas. All their nodes have
                to be in their first positions then, also in a later increment: areas are those at ``positions``.
            dofs: as for ``ContactInterface``.
            equations: as for ``ContactInterface``.
            options: ``weight``, ``basis`` and ``feature_angle`` have to be those that the window was made with.

        Raises:
            InterfaceError: as for ``ContactInterface``; ``"other-than-window"`` for other options,
                ``"incomplete-window"`` for a window with something missing.

        """
        made = cls.__new__(cls)
        made._options = _named_options(cls.in_window, options)
        positions = floats("positions", positions, "p", 3)
        made._interface = _native.Interface.in_window(
            _checked(window),
            ints("slaves", slaves, "s"),
            positions,
            None if slave_facets is None else facets("slave_facets", slave_facets),
            made._options,
            _equations(dofs, equations, len(positions)),
        )
        return made

    @property
    def is_in_window(self) -> bool:
        """Whether there is a window of the master surface only."""
        return self._interface.is_in_window()

    def window(self, boxes: ArrayLike, skin: float) -> Window:
        """What slaves in boxes can need of the master surface, at the positions of the last update or refresh.

        Args:
            boxes: lowest and highest corners, shape (b, 2, 3), length. See ``boxes_around``.
            skin: how far nodes of the surface may move before a new window is to be made, length.

        Raises:
            InterfaceError: ``"invalid-box"``; ``"window-needs-domains"`` for facets and other rules than ``"domains"``;
                ``"in-window"`` if there is a window only.

        """
        return Window._of(self._interface.window(_boxes(boxes), number("skin", skin)))

    @property
    def options(self) -> Options:
        """The options."""
        return self._options

    @property
    def slaves(self) -> Ints:
        """The slave nodes, in the order of all results, shape (s,)."""
        return self._interface.slaves()

    @property
    def equations(self) -> int:
        """Number of equations: rows of forces and tangent."""
        return self._interface.equations()

    def refresh_pairing(self, positions: ArrayLike, *, renew: bool = False) -> RefreshReport:
        """Takes over the positions, shape (p, 3), and pairs every slave anew.

        With domains of influence the list of a slave stays while slave and masters together have moved by less than
        half its skin, 0.06 of the shortest half axis of its domains, and not so far that another sheet may be the
        closest one. Another list changes no gap, unless the slave comes to where the old one does not reach, such as
        another sheet: the report tells. Domains lie in the first configuration and are never renewed: they turn and
        stretch with the master.

        While the interface is frozen it is an ``update``, and the report says so.

        Args:
            positions: of all nodes.
            renew: makes all lists anew, so that they follow from the positions alone: after a restart patterns are
                those of a run that makes them anew there, too.

        Raises:
            InterfaceError: for another number of positions, or one that is not finite.

        """
        report = self._interface.refresh_pairing(floats("positions", positions, "p", 3), flag("renew", renew))
        for name, kind in (
            ("smallest_gap_lost", SlaveGap),
            ("smallest_gap_gained", SlaveGap),
            ("largest_gap_jump", GapJump),
        ):
            if report[name] is not None:
                report[name] = kind(*report[name])
        return RefreshReport(**report)

    def freeze(self) -> None:
        """Holds the pairing, for instance over the iterations of an increment, until ``thaw``."""
        self._interface.set_frozen(True)

    def thaw(self) -> None:
        """Ends what ``freeze`` began."""
        self._interface.set_frozen(False)

    @property
    def frozen(self) -> bool:
        """Whether the pairing is held."""
        return self._interface.frozen

    def update(self, positions: ArrayLike) -> None:
        """Takes over the positions of the next evaluation, shape (p, 3). The pairing stays.

        Raises:
            InterfaceError: for another number of positions, or one that is not finite.

        """
        self._interface.update(floats("positions", positions, "p", 3))

    def follow(self, positions: ArrayLike) -> bool:
        """As ``update``, but with domains of influence the lists of nodes follow.

        A slave stays with its side of the surface. Contacts that are lost with the old lists are in the report of the
        next ``refresh_pairing``.

        Returns:
            Whether lists are others now, as something had moved too far for them, see ``refresh_pairing``: the sparsity
            pattern then is another one. False while the interface is frozen.

        Raises:
            InterfaceError: for another number of positions, or one that is not finite.

        """
        return self._interface.follow(floats("positions", positions, "p", 3))

    def evaluate(self, mode: Mode = "hessian") -> Contacts:
        """Evaluates all contacts at the positions of the last update or refresh, in parallel, without the GIL.

        Args:
            mode: ``"value"``; ``"gradient"``, enough for forces and tangents; ``"hessian"`` keeps every M, which
                ``contact`` and the exact ``triplets`` show, and which takes the most memory of all.

        Raises:
            InterfaceError: ``"not-refreshed"`` before the first refresh; if the results do not fit into memory.

        """
        self._interface.evaluate(word("mode", mode))
        return self.contacts

    @property
    def contacts(self) -> Contacts:
        """What the last evaluation gave.

        Raises:
            InterfaceError: ``"not-evaluated"`` if positions or pairing have changed since.

        """
        gap, foot, normal, area = self._interface.points()
        return Contacts(gap, foot.reshape(-1, 3), normal.reshape(-1, 3), area, self._interface.outcomes())

    def contact(self, k: int) -> Contact:
        """The contact of the k-th slave (its place among ``slaves``), with N and M."""
        fields = self._interface.contact(count("k", k))
        if fields["hessian"] is not None:
            fields["hessian"] = unpacked(fields["hessian"], len(fields["gradient"]))
        return Contact(**fields)

    def foot_derivatives(self) -> ContactFeet:
        """The masters' weights in the feet of all slaves, and the first derivatives of foot and normal.

        What a law of the host's own at the foot needs (wear, heat, adhesion), at the positions of the last update or
        refresh with the pairing held. It needs no evaluation, and leaves the last one as it is.

        Raises:
            InterfaceError: ``"not-refreshed"`` before the first refresh; if the results do not fit into memory.

        """
        fields = self._interface.feet()
        for name in ("foot", "normal"):
            fields[name] = fields[name].reshape(-1, 3)
            fields[f"{name}_jacobian"] = fields[f"{name}_jacobian"].reshape(-1, 3, 3)
        return ContactFeet(**fields)

    def pairing(self, k: int) -> Pairing:
        """What the k-th slave is paired with.

        Raises:
            InterfaceError: if it is not paired.

        """
        fields = self._interface.pairing(count("k", k))
        fields["positions"] = fields["positions"].reshape(-1, 3)
        if "frame" in fields:
            fields["frame"] = fields["frame"].reshape(3, 3)
        if "offsets" in fields:
            offsets = fields.pop("offsets").reshape(-1, 3)
            metrics = np.zeros((len(offsets), 3, 3))
            metrics[:, *np.triu_indices(3)] = fields.pop("metrics").reshape(-1, 6)
            fields["material"] = MaterialNodes(offsets, metrics)
        return Pairing(**fields)

    @property
    def _kept(self) -> _native.Interface:
        return self._interface

    def forces(
        self,
        penalty: float,
        *,
        multipliers: ArrayLike | None = None,
        friction: Friction | None = None,
        normal: TabulatedPressure | None = None,
        out: Floats | None = None,
    ) -> Floats:
        """The contact forces on the nodes, Σ f_k N_k, shape (equations,), and friction.

        Args:
            penalty: ε > 0, force per length, or per length³ if contacts carry areas.
            multipliers: λ ≥ 0, one force per slave, for the augmented Lagrangian.
            friction: coefficient of Coulomb's friction, or with it the stiffness of contacts that stick, in the unit
                of the penalty, which it is by default, and the traction that no contact exceeds; or a ``Coulomb``. It
                needs ``accept`` before the first increment.
            normal: pressures by table in the place of ε g, without multipliers. The penalty then only estimates where
                contacts that close have touched: about the stiffness of the table in contact.
            out: a float64 vector to add to, which is returned.

        Raises:
            InterfaceError: ``"not-evaluated"``.
            AssemblyError: for the penalty or multipliers, in value mode, or if a sum overflows.

        """
        if out is None:
            out = new("forces", self.equations)
            out.fill(0.0)
        law = law_of(penalty, multipliers, friction=friction, normal=normal)
        check_overlap({"multipliers": law.multipliers}, {"out": vector("out", out)})
        self._interface.add_forces(law, out)
        return out

    def tangent(
        self,
        penalty: float,
        *,
        multipliers: ArrayLike | None = None,
        tangent: Tangent = "exact",
        friction: Friction | None = None,
        normal: TabulatedPressure | None = None,
    ) -> scipy.sparse.csr_matrix:
        """K = −∂R/∂x as scipy compressed rows, shape (equations, equations), force per length.

        The pattern is the union over all paired slaves, whether they carry force or not: it stays the same until
        ``refresh_pairing`` or ``follow`` changes the lists of nodes. The matrix is symmetric to the last bit, unless
        friction makes the exact one unsymmetric, and indefinite in general for ``"exact"``. It shares its index
        arrays with ``pattern``, and they are read-only: ``copy()`` it where its structure is to change.

        After ``evaluate("gradient")`` M of the slaves that carry force is evaluated some hundred at a time, added and
        forgotten. The numbers are those after ``evaluate("hessian")``, bit for bit, and the memory for all M is saved,
        8.3 kB for a slave with 14 masters.

        Args:
            penalty: as for ``forces``.
            multipliers: as for ``forces``.
            tangent: ``"exact"``, or ``"gauss-newton"`` for Σ ε N Nᵀ alone, positive semidefinite; ``adaptive_tangent``
                says which.
            friction: as for ``forces``.
            normal: as for ``forces``.

        """
        values = self.tangent_values(
            penalty, multipliers=multipliers, tangent=tangent, friction=friction, normal=normal
        )
        offsets, columns = self.pattern()
        size = self.equations
        matrix = scipy.sparse.csr_matrix((values, columns, offsets), shape=(size, size))
        # Nobody need look: rows ascend, and no entry is there twice.
        matrix.has_sorted_indices = matrix.has_canonical_format = True
        return matrix

    def pattern(self) -> tuple[Indices, Indices]:
        """Row offsets, shape (equations + 1,), and columns, ascending in each row, of the union pattern.

        They are int32, or int64 where there are 2³¹ entries or more, and read-only. They are the same objects until
        the lists of nodes change.
        """
        return self._interface.pattern()

    def tangent_values(
        self,
        penalty: float,
        *,
        multipliers: ArrayLike | None = None,
        tangent: Tangent = "exact",
        friction: Friction | None = None,
        normal: TabulatedPressure | None = None,
        out: Floats | None = None,
    ) -> Floats:
        """The values of ``tangent``, one per column of ``pattern``; added to ``out`` if that is given."""
        add = out is not None
        if out is None:
            out = new("tangent", self._interface.entries())
        law = law_of(penalty, multipliers, tangent, friction, normal)
        check_overlap({"multipliers": law.multipliers}, {"out": vector("out", out)})
        self._interface.fill_tangent(law, out, add)
        return out

    def csr_map(self, matrix: Any) -> CsrMap:
        """Where the tangent goes in a matrix that a host has already: see ``CsrMap``.

        Args:
            matrix: a scipy csr matrix or array, shape (equations, equations), or its row offsets and columns, int32
                or int64. Columns ascend in each row. It may have any entries besides those of ``pattern``, all of
                which have to be there. Nothing of it is kept.

        Raises:
            InterfaceError: ``"not-evaluated"``.
            AssemblyError: ``"missing-entry"`` with the first row and column that the matrix lacks; ``"output-length"``
                or ``"invalid-row"`` for arrays that are no such matrix.
            InputError: for arrays of another type.

        """
        rows = matrix if isinstance(matrix, tuple) else _indices(matrix)
        if len(rows) != 2:
            raise InputError(f"row offsets and columns are needed, not {len(rows)} arrays", "wrong-shape")
        offsets, columns = rows
        return CsrMap(self._interface, self._interface.csr_map(_rows(offsets, columns)))

    def operator(
        self,
        penalty: float,
        *,
        multipliers: ArrayLike | None = None,
        tangent: Tangent = "exact",
        friction: Friction | None = None,
        normal: TabulatedPressure | None = None,
    ) -> TangentOperator:
        """The tangent at the positions of the last update or refresh as an operator that needs no matrix.

        It needs no evaluation either: what carries force is evaluated for it. It stays what it is when the interface
        moves on. With friction it is not symmetric in general.

        Args:
            penalty: as for ``forces``.
            multipliers: as for ``forces``.
            tangent: as for ``tangent``.
            friction: as for ``forces``; it needs ``accept`` before the first increment.
            normal: as for ``forces``.

        Raises:
            AssemblyError: for the penalty, multipliers or friction; ``"no-slip"`` before the first ``accept``.
            InterfaceError: ``"not-refreshed"`` before the first refresh; if it does not fit into memory.

        """
        law = law_of(penalty, multipliers, tangent, friction, normal)
        return TangentOperator(self._interface.operator(law))

    def triplets(
        self,
        penalty: float,
        *,
        multipliers: ArrayLike | None = None,
        tangent: Tangent = "exact",
        friction: Friction | None = None,
        normal: TabulatedPressure | None = None,
        triangle: Literal["full", "lower"] = "full",
    ) -> tuple[Ints, Ints, Floats]:
        """Rows, columns and values of the tangents of all contacts that carry force, to be summed."""
        lower = choice("triangle", triangle, "full", "lower") == "lower"
        return self._interface.triplets(law_of(penalty, multipliers, tangent, friction, normal), lower)

    def normal_forces(
        self,
        penalty: float,
        *,
        multipliers: ArrayLike | None = None,
        normal: TabulatedPressure | None = None,
    ) -> Floats:
        """max(0, λ − ε g) of every slave, shape (s,), force; also the next λ of the augmented Lagrangian.

        With ``normal`` area times its pressure.
        """
        return self._interface.normal_forces(law_of(penalty, multipliers, normal=normal))

    def pressures(
        self,
        penalty: float,
        *,
        multipliers: ArrayLike | None = None,
        normal: TabulatedPressure | None = None,
    ) -> Floats:
        """Normal forces over tributary areas, shape (s,); forces if contacts carry no areas."""
        forces = self.normal_forces(penalty, multipliers=multipliers, normal=normal)
        return forces / self._interface.points()[3]

    def friction(
        self,
        penalty: float,
        *,
        friction: Friction,
        multipliers: ArrayLike | None = None,
        normal: TabulatedPressure | None = None,
    ) -> SlaveFriction:
        """Traction, state and slip of every slave, of the last evaluation; over faces ``evaluate`` returns them.

        ``accept`` ends the evaluation: ask before it. Arguments are those of ``forces``.

        Raises:
            InterfaceError: ``"not-evaluated"``.
            AssemblyError: as for ``forces``; ``"no-slip"`` before the first ``accept``.

        """
        law = law_of(penalty, multipliers, friction=friction, normal=normal)
        tractions, states, slip = self._interface.friction(law)
        return SlaveFriction(tractions.reshape(-1, 3), states, slip)

    def cut_back(self, limit: float = 0.25) -> CutBack:
        """A hint, after an evaluation, whether the increment went too far for the pairing.

        The rule of ``dc_cutback`` in C, the least of

        * ``limit`` R/(−g) for a slave deeper than ``limit`` × R, the support radius (with domains of influence
          the shortest half axis of the domains on its list; node to facet: the extent of the facet);
        * 0.5 for a slave that penetrated and whose foot lies outside its domain of influence now;
        * 0.25 for one whose element has no result for another reason;

        but 0.1 at least. A slave penetrated if its gap was negative when it last had one, in the last refresh or since.

        Raises:
            InterfaceError: ``"not-evaluated"``.

        """
        factor, cause = self._interface.cut_back(number("limit", limit))
        return CutBack(factor, *cause) if cause else CutBack(factor)

    def __reduce__(self) -> NoReturn:
        # A copy would go on with a pairing of its own: whoever hands an interface to another process had better know.
        raise TypeError(
            "a ContactInterface cannot be pickled or copied: its pairing has a history of its own. Send the arrays it "
            "was made of and its options, and make one in each process"
        )

    def __repr__(self) -> str:
        return f"<ContactInterface of {len(self.slaves)} slaves, {self._options.element}>"


class CsrMap:
    """Where the tangents of a ``ContactInterface`` go in the values of a matrix that a host has already.

    ``ContactInterface.csr_map`` makes it. It serves any matrix of the same structure, for as long as the lists of nodes
    stay: a refresh or ``follow`` that reports new ones needs another map::

        entries = interface.csr_map(stiffness)
        matrix = stiffness.copy()
        entries.add(matrix.data, penalty)                 # matrix is stiffness + K
    """

    def __init__(self, interface: _native.Interface, map: _native.Map) -> None:
        self._interface, self._map = interface, map

    @property
    def entries(self) -> int:
        """Number of values of the matrix."""
        return self._map.entries

    @property
    def equations(self) -> int:
        """Number of its rows and columns."""
        return self._map.equations

    def add(
        self,
        values: Floats,
        penalty: float,
        *,
        multipliers: ArrayLike | None = None,
        tangent: Tangent = "exact",
        friction: Friction | None = None,
        normal: TabulatedPressure | None = None,
    ) -> int:
        """Adds K = −∂R/∂x to the values of a matrix, where they are.

        Args:
            values: ``matrix.data``, shape (entries,), float64.
            penalty: as for ``ContactInterface.tangent``, and so are the others.
            multipliers: as for ``ContactInterface.tangent``.
            tangent: as for ``ContactInterface.tangent``.
            friction: as for ``ContactInterface.tangent``.
            normal: as for ``ContactInterface.tangent``.

        Returns:
            The number of contacts that carry force.

        Raises:
            InterfaceError: ``"not-evaluated"``.
            AssemblyError: ``"pattern-mismatch"`` if the lists of nodes are others than those of the map; for the
                penalty, multipliers or another number of values, or if a sum overflows.

        """
        law = law_of(penalty, multipliers, tangent, friction, normal)
        check_overlap({"multipliers": law.multipliers}, {"values": vector("values", values)})
        return self._interface.add_tangent(self._map, law, values)

    def __reduce__(self) -> NoReturn:
        raise TypeError("a CsrMap cannot be pickled or copied: it belongs to its interface, which cannot be, either")

    def __repr__(self) -> str:
        return f"<CsrMap into {self.entries} entries of {self.equations} rows>"


def _indices(matrix: Any) -> tuple[Any, Any]:
    """Row offsets and columns of a scipy matrix."""
    if not (scipy.sparse.issparse(matrix) and matrix.format == "csr"):
        message = f"a csr matrix, or row offsets and columns are needed, not {type(matrix).__name__}"
        raise InputError(message, "wrong-type")
    return matrix.indptr, matrix.indices


def _rows(offsets: Any, columns: Any) -> tuple[Indices, Indices]:
    """The same, both int32 if they are, else int64."""
    if isinstance(offsets, np.ndarray) and isinstance(columns, np.ndarray):
        both = (offsets, columns)
        if all(array.dtype == np.int32 and array.ndim == 1 and array.flags.c_contiguous for array in both):
            return both if all(array.flags.aligned for array in both) else (offsets.copy(), columns.copy())
    return ints("row offsets", offsets, "equations + 1"), ints("columns", columns, "entries")
