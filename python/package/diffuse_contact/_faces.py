"""Contact integrated over the slave's faces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, NoReturn

import numpy as np
import scipy.sparse
from numpy.typing import ArrayLike, NDArray

from . import _arrays, _native
from ._arrays import (
    Facets,
    Floats,
    Ints,
    Planes,
    check_overlap,
    count,
    facets,
    floats,
    new,
    planes,
    vector,
    word,
)
from ._batch import Mode
from ._history import FrictionHistory
from ._interface import Options, _equations, _named_options, _options
from ._law import Friction, TabulatedPressure, Tangent, law_of
from ._surface import MasterSurface
from ._window import Window, _checked


def flat_facets(faces: ArrayLike) -> Ints:
    """The flat facets between all nodes of faces of second order, shape (m, 4), the last node −1 for triangles.

    A face of 6 nodes has 4 facets, one of 8 has 5, one of 9 has 4. They are the facets of ``MasterSurface`` and of
    ``FaceInterface``; ``quadratic`` makes the faces carry the forces on them.

    Args:
        faces: nodes, shape (f, 6), (f, 8) or (f, 9): corners counter-clockwise seen from outside, then the middles of
            the edges from the first corner on, then the centre.

    Raises:
        InputError: for another shape or a negative node.

    """
    rows = [_native.flat_facets(array).reshape(-1, 4) for array in _arrays.quadratic("faces", faces)]
    return np.concatenate(rows) if rows else np.empty((0, 4), dtype=np.int64)


class FaceReport(NamedTuple):
    """What cutting the faces gave: points, those paired with masters, faces with points.

    ``grown`` says whether nodes couple that did not since the last ``refresh``: the sparsity pattern is larger then.
    """

    points: int
    paired: int
    faces: int
    grown: bool


@dataclass(frozen=True)
class FaceContacts:
    """The contact of all s nodes of the slave's faces. Gap and normal are NaN where no facet lies over a node's faces.

    Attributes:
        gap: average gap, shape (s,), length; positive apart, negative penetrating.
        area: area over the master in the first configuration, shape (s,), length².
        pressure: shape (s,), force per area.
        normal: mean unit normals of the master, shape (s, 3).
        outcomes: ``"contact"``, or the code of the reason why there is none.
        friction: tractions on the slave, shape (s, 3), force per area; 0 without friction.
        friction_states: ``"open"``, ``"stick"`` or ``"slip"``.
        slip: from the anchor, or of a slave that was open from its place of touch, shape (s,), length: the elastic
            slip, and where it slides what it has slid in the increment besides. With ``augmented=True`` from where
            it stuck, without its multiplier.

    """

    gap: Floats
    area: Floats
    pressure: Floats
    normal: Floats
    outcomes: list[str]
    friction: Floats
    friction_states: list[str]
    slip: Floats

    @property
    def is_contact(self) -> NDArray[np.bool_]:
        """Which nodes have a result, shape (s,)."""
        return ~np.isnan(self.gap)

    @property
    def force(self) -> Floats:
        """Pressure times area, shape (s,)."""
        return self.pressure * self.area


@dataclass(frozen=True)
class FacePoints:
    """The q integration points that lie over the master, face by face.

    Attributes:
        face: numbers of their faces among the slave's, shape (q,).
        position: on the slave's own smooth surface, shape (q, 3), length.
        area: what each stands for of its face in the first configuration, shape (q,), length².
        gap: shape (q,), length.
        normal: unit normals of the master, shape (q, 3).
        pressure: Σ N_A p_A of the nodes of its face, with ``pressures="points"`` its own, shape (q,), force per area.
        friction: the same of tractions on the slave, shape (q, 3), force per area; 0 without friction.

    """

    face: Ints
    position: Floats
    area: Floats
    gap: Floats
    normal: Floats
    pressure: Floats
    friction: Floats


class FaceInterface(FrictionHistory):
    """Contact integrated over the slave's faces, which passes the patch test between meshes that do not match.

    Kinematics are those of the smooth surfaces of both sides, forces go by the shape functions of the faces, and
    pressures are averaged to the slave's nodes, unless ``pressures="points"`` asks for those of points::

        ḡ_A = ∫ N_A g dA / ∫ N_A dA        p_A = max(0, λ_A − ε ḡ_A)

    In a Newton iteration: ``refresh`` once an increment, then at each iteration ``update``, ``evaluate``, ``forces``
    and ``tangent``. With friction ``accept`` each increment that has converged: that is all of the history. Forces and
    moments balance; there is no energy, and the tangent is not symmetric.

    Args:
        master: the master surface.
        slave_facets: the slave's faces, as for ``MasterSurface``, counter-clockwise seen from outside; none of their
            nodes may be on the master. None: the master is in contact with itself, and its nodes are the slaves; the
            penalty is half of that between two surfaces then.
        positions: first positions of all nodes, shape (p, 3), length.
        degree: 2 or 4, of the polynomials integrated exactly on each piece of a face; 4 always for pieces between a
            quadrilateral of second order and what lies over it.
        pressures: where they follow from gaps: ``"nodes"``, from the average gap around each, or ``"points"``, at each
            integration point from its own gap. Points are for faces that are coarse beside the master's curvature,
            where an average gap closes late; a stiff penalty makes their pressures rough.
        dofs: equations of the nodes' x, y and z, shape (p, 3), −1 where there is none; if left out, 3·node + axis.
        equations: number of equations; if left out, 3p, or the largest of ``dofs`` plus 1.
        symmetry: planes of symmetry of both surfaces, pairs of a point and the unit normal to the side of the model.
        quadratic: faces of second order of either side, an array as for ``flat_facets`` or several. They carry the
            forces on their flat facets by all of their shape functions.
        options: the fields of ``Options``, by keyword.

    Raises:
        InterfaceError: for faces, positions or options that are refused.
        AssemblyError: for ``dofs`` that name an equation twice or one that does not exist.
        InputError: for a wrong shape, type or name.

    """

    def __init__(
        self,
        master: MasterSurface,
        slave_facets: Facets | None,
        positions: ArrayLike,
        *,
        degree: int = 2,
        pressures: Literal["nodes", "points"] = "nodes",
        dofs: ArrayLike | None = None,
        equations: int | None = None,
        symmetry: Planes = (),
        quadratic: ArrayLike | Sequence[ArrayLike] = (),
        **options: Any,
    ) -> None:
        self._options = _options(FaceInterface, master, options)
        positions = floats("positions", positions, "p", 3)
        self._faces = _native.Faces(
            master._surface,
            None if slave_facets is None else facets("slave_facets", slave_facets),
            positions,
            self._options,
            count("degree", degree),
            word("pressures", pressures),
            _equations(dofs, equations, len(positions)),
            planes("symmetry", symmetry),
            _arrays.quadratic("quadratic", quadratic),
        )

    @classmethod
    def in_window(
        cls,
        master: Window,
        slave: Window,
        positions: ArrayLike,
        *,
        degree: int = 2,
        pressures: Literal["nodes", "points"] = "nodes",
        dofs: ArrayLike | None = None,
        equations: int | None = None,
        quadratic_master: ArrayLike | Sequence[ArrayLike] = (),
        quadratic_slave: ArrayLike | Sequence[ArrayLike] = (),
        **options: Any,
    ) -> FaceInterface:
        """An interface of faces that know a window of either surface only.

        The faces are those that meet the boxes of the slave's window. Gaps, pressures and areas after a ``refresh`` are
        those of an interface of the whole surfaces, bit for bit, or a node has the outcome ``"beyond-window"`` and no
        pressure. Rows of forces and tangent are those of the whole where all nodes of the faces at their node are
        known. The history of friction names nodes by their numbers in the whole surfaces: two parts of
        ``split_history`` go with each slave from window to window.

        Args:
            master: holds these faces and what is within the limit of the distance, until it is made anew.
            slave: cut once, in the first positions, from a surface of the slave's faces.
            positions: first those of ``master.nodes``, then those of ``slave.nodes``, where they were when the window
                of the master was made.
            degree: as for ``FaceInterface``.
            pressures: as for ``FaceInterface``.
            dofs: as for ``FaceInterface``.
            equations: as for ``FaceInterface``.
            quadratic_master: faces of second order of the master, as ``quadratic`` of ``FaceInterface``, with the
                numbers of their nodes in the whole surface: all that have a node in the window; more do no harm.
            quadratic_slave: the same of the slave.
            options: those that the windows were made with; ``distance_limit`` has to be given.

        Raises:
            InterfaceError: ``"invalid-option"`` without a limit of the distance; ``"other-than-window"`` for other
                options, or where planes of symmetry differ; ``"incomplete-window"`` for a window that lacks something;
                ``"repeated-node"`` for a node twice in a face; ``"in-window"`` later for what takes the whole.

        """
        made = cls.__new__(cls)
        made._options = _named_options(cls.in_window, options)
        positions = floats("positions", positions, "p", 3)
        made._faces = _native.Faces.in_window(
            _checked(master),
            _checked(slave),
            positions,
            made._options,
            count("degree", degree),
            word("pressures", pressures),
            _equations(dofs, equations, len(positions)),
            [
                _arrays.quadratic("quadratic_master", quadratic_master),
                _arrays.quadratic("quadratic_slave", quadratic_slave),
            ],
        )
        return made

    @property
    def is_in_window(self) -> bool:
        """Whether there are windows of the surfaces only."""
        return self._faces.is_in_window()

    @property
    def options(self) -> Options:
        """The options."""
        return self._options

    @property
    def slaves(self) -> Ints:
        """The nodes of the slave's faces, ascending, in the order of all results, shape (s,).

        A node on an edge sharper than the feature angle is there once for each sheet of the slave that meets there.
        """
        return self._faces.slaves()

    @property
    def straight(self) -> int:
        """Middles of edges and faces where the slave's own nodes carry no fit: its faces are flat there."""
        return self._faces.straight()

    @property
    def equations(self) -> int:
        """Number of equations: rows of forces and tangent."""
        return self._faces.equations()

    def refresh(self, positions: ArrayLike) -> FaceReport:
        """Takes over the positions, shape (p, 3), and cuts the faces anew.

        Raises:
            InterfaceError: for another number of positions, or one that is not finite.

        """
        return FaceReport(*self._faces.take(floats("positions", positions, "p", 3), True))

    def update(self, positions: ArrayLike) -> FaceReport:
        """As ``refresh``, in every iteration: near equilibrium faces stay cut as they are.

        Raises:
            InterfaceError: for another number of positions, or one that is not finite.

        """
        return FaceReport(*self._faces.take(floats("positions", positions, "p", 3), False))

    def cliques(self) -> tuple[Ints, Ints]:
        """Which nodes couple with one another, for the pattern of a host's matrix: offsets and nodes.

        Those of clique k are ``nodes[offsets[k] : offsets[k + 1]]``, ascending. An entry of the tangent is in the rows
        and columns of two nodes of one clique. They hold all that has coupled since the last ``refresh``: where
        ``update`` says ``grown`` they are more than before. They need no evaluation; before the first refresh there
        are none.
        """
        return self._faces.cliques()

    def evaluate(
        self,
        penalty: float,
        *,
        multipliers: ArrayLike | None = None,
        friction: Friction | None = None,
        normal: TabulatedPressure | None = None,
        mode: Mode = "hessian",
    ) -> FaceContacts:
        """Gaps, pressures and forces at the positions of the last update or refresh, in parallel, without the GIL.

        Args:
            penalty: ε > 0, force per length³.
            multipliers: λ_k ≥ 0 of the augmented Lagrangian, shape (s,): ``pressure`` of the evaluation before.
            friction: coefficient of Coulomb's friction, or with it the stiffness of contacts that stick, in the unit
                of the penalty, which it is by default, and the traction that no contact exceeds; or a ``Coulomb``. It
                needs ``accept`` before the first increment.
            normal: pressures by table in the place of ε g, without multipliers. The penalty then only estimates where
                contacts that close have touched: about the stiffness of the table in contact.
            mode: ``"value"`` for pressures alone, ``"gradient"`` for forces and the Gauss–Newton tangent,
                ``"hessian"`` for the exact tangent.

        Raises:
            InterfaceError: ``"not-refreshed"`` before the first refresh or update; for the penalty or multipliers, or
                if the results do not fit into memory; ``"no-slip"`` for friction before the first ``accept``.
            AssemblyError: for a coefficient or a stiffness that is none.

        """
        self._faces.evaluate(law_of(penalty, multipliers, friction=friction, normal=normal), word("mode", mode))
        return self.contacts

    @property
    def _kept(self) -> _native.Faces:
        return self._faces

    @property
    def contacts(self) -> FaceContacts:
        """What the last evaluation gave.

        Raises:
            InterfaceError: ``"not-evaluated"`` if positions have changed since.

        """
        gap, area, pressure, normal, outcomes = self._faces.nodes()
        friction, states, slip = self._faces.friction()
        return FaceContacts(gap, area, pressure, normal.reshape(-1, 3), outcomes, friction.reshape(-1, 3), states, slip)

    @property
    def missed(self) -> int:
        """Points of loaded faces that carry no force in the last evaluation although they should.

        Those below their facet whose element has no result, and those without a place on their own face or the facet.
        In gradient mode also those whose line of force meets no place of the facet, or whose derivatives overflow.

        Raises:
            InterfaceError: ``"not-evaluated"`` if positions have changed since.

        """
        return self._faces.missed()

    @property
    def points(self) -> FacePoints:
        """Contact at the integration points, by the pressures of the last evaluation; found anew each time.

        Raises:
            InterfaceError: ``"not-evaluated"`` if positions have changed since.

        """
        face, (position, area, gap, normal, pressure, friction) = self._faces.points()
        return FacePoints(
            face, position.reshape(-1, 3), area, gap, normal.reshape(-1, 3), pressure, friction.reshape(-1, 3)
        )

    def forces(self, *, out: Floats | None = None) -> Floats:
        """The contact forces on the nodes, shape (equations,); added to ``out`` if that is given.

        Raises:
            InterfaceError: ``"not-evaluated"``.
            AssemblyError: in value mode, or if a sum overflows.

        """
        if out is None:
            out = new("forces", self.equations)
            out.fill(0.0)
        self._faces.add_forces(vector("out", out))
        return out

    def tangent(self, tangent: Tangent = "exact") -> scipy.sparse.csr_matrix:
        """K = −∂R/∂x as scipy compressed rows, shape (equations, equations), force per length; not symmetric.

        It holds the integration points in their places on the faces, as ``update`` does while nothing has moved by more
        than 1e-5 of the smallest facet. A check by differences takes steps below 1e-6 of a facet.

        Args:
            tangent: ``"exact"``, or ``"gauss-newton"`` without what the directions of the forces add;
                ``adaptive_tangent`` says which.

        Raises:
            InterfaceError: ``"not-evaluated"``.
            AssemblyError: if the evaluation was for fewer derivatives.

        """
        rows, columns, values = self._faces.triplets(word("tangent", tangent))
        size = self.equations
        return scipy.sparse.csr_matrix((values, (rows, columns)), shape=(size, size))

    def product(self, v: ArrayLike, tangent: Tangent = "exact", *, out: Floats | None = None) -> Floats:
        """K v without a matrix, shape (equations,); added to ``out`` if that is given. With friction, too.

        It is the K of ``tangent`` at the last evaluation. It differs from ``tangent() @ v`` by rounding and does not
        depend on the number of threads.

        Args:
            v: shape (equations,), length.
            tangent: as for ``tangent``.
            out: is added to, and returned; no part of ``v``.

        Raises:
            InterfaceError: ``"not-evaluated"``.
            AssemblyError: for another length, if the evaluation was for fewer derivatives, or if a sum overflows.
            InputError: for arrays of another type or that overlap.

        """
        if out is None:
            out = new("product", self.equations)
            out.fill(0.0)
        v, word_of = floats("v", v, "equations"), word("tangent", tangent)
        check_overlap({"v": v}, {"out": vector("out", out)})
        self._faces.add_product(word_of, v, out)
        return out

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            "a FaceInterface cannot be pickled or copied: send the arrays it was made of and its options, and make one "
            "in each process"
        )

    def __repr__(self) -> str:
        return f"<FaceInterface of {len(self.slaves)} slaves, {self._options.element}>"
