"""What an interface answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ._arrays import Floats, Ints


class GapJump(NamedTuple):
    """The gap of one slave by the old and by the new pairing, length."""

    slave: int
    before: float
    after: float


class SlaveGap(NamedTuple):
    """The gap of one slave, length."""

    slave: int
    gap: float


class FrictionReport(NamedTuple):
    """What friction did in an increment, in numbers of slaves, and its work, energy.

    ``unanchored`` slaves carry force without friction: they had no gap at the end of the increment before. ``dropped``
    slaves were closed then and have lost their contact element.
    """

    stuck: int
    sliding: int
    unanchored: int
    dropped: int
    dissipated: float


class SlaveFriction(NamedTuple):
    """What friction does at the s slaves; zeros where a slave is open.

    Attributes:
        friction: tractions on the slaves, shape (s, 3), force per area; forces if contacts carry no areas.
        friction_states: ``"open"``, ``"stick"`` or ``"slip"``.
        slip: from the anchor, or of a slave that was open from its place of touch, shape (s,), length: the elastic
            slip, and where it slides what it has slid in the increment besides. With ``augmented=True`` from where
            it stuck, without its multiplier.

    """

    friction: Floats
    friction_states: list[str]
    slip: Floats


@dataclass(frozen=True)
class RefreshReport:
    """What a refresh of the pairing did, in numbers of slaves.

    Attributes:
        paired: with a pairing now; the sum of ``kept`` (with domains of influence, those whose list stays), ``renewed``
            (anew with the same masters), ``changed`` (with other masters) and ``gained`` (without a pairing before).
        lost: without a pairing now, but with one before.
        without: without a pairing now, by the code of the reason.
        fallbacks: what the searches had to give up: ``"none"``, ``"extended"``, ``"linear"``.
        deep: paired and deeper below the closest facet than a tenth of its size, the root of its area, when paired.
            If most slaves are, the master may be inside out.
        contacts_lost: with a gap by the old pairing at these positions, but none by the new: their forces vanish. Those
            that ``follow`` lost in this way since the refresh before count too, unless they have a gap again.
        contacts_gained: the other way round: forces may appear.
        smallest_gap_lost: of the contacts lost, that with the smallest gap when it was lost.
        smallest_gap_gained: of the contacts gained, that with the smallest gap.
        largest_gap_jump: where the refresh changed the gap most, if it changed any.
        frozen: whether the pairing was held (``ContactInterface.freeze``): the rest then is zero.
        rebuilt: whether the pairing was made anew. With domains of influence that is so only if something had moved by
            more than half the skin of the lists; the sparsity pattern stays what it was otherwise.

    """

    paired: int
    kept: int
    renewed: int
    changed: int
    gained: int
    lost: int
    without: dict[str, int]
    fallbacks: dict[str, int]
    deep: int
    contacts_lost: int
    contacts_gained: int
    smallest_gap_lost: SlaveGap | None
    smallest_gap_gained: SlaveGap | None
    largest_gap_jump: GapJump | None
    frozen: bool = False
    rebuilt: bool = True


@dataclass(frozen=True)
class Contacts:
    """The contacts of all s slaves, in their order. Gap, foot and normal are NaN where there is no contact.

    Attributes:
        gap: g, shape (s,), length; positive apart, negative penetrating.
        foot: foot points, shape (s, 3).
        normal: unit normals at the feet, towards the outward side, shape (s, 3).
        area: tributary areas, shape (s,), length²; 1 if the interface has none.
        outcomes: ``"contact"``, or the code of the reason why there is none.

    """

    gap: Floats
    foot: Floats
    normal: Floats
    area: Floats
    outcomes: list[str]

    @property
    def is_contact(self) -> NDArray[np.bool_]:
        """Which slaves have a result, shape (s,)."""
        return ~np.isnan(self.gap)

    @property
    def penetration(self) -> Floats:
        """max(0, −g), shape (s,), length; 0 where there is no contact."""
        return np.fmax(0.0, -self.gap)


@dataclass(frozen=True)
class Contact:
    """The contact of one slave with its derivatives.

    Attributes:
        slave: its node.
        masters: nodes 1 … n it is paired with; none without a pairing.
        outcome: ``"contact"`` or the code of the reason why there is none.
        reason: the same as a sentence; None for a contact.
        fallback: what the neighbour search gave up: ``"none"``, ``"extended"`` or ``"linear"``; None without contact.
        area: tributary area, length²; 1 if the interface has none.
        gap: g, length. None, as all that follows, without contact.
        foot: foot point, shape (3,).
        normal: unit normal at the foot, shape (3,).
        gradient: N, shape (3(n+1),), ordered slave, master 1, …, master n; None below gradient mode.
        hessian: M, shape (3(n+1), 3(n+1)), 1/length; None below Hessian mode.

    """

    slave: int
    masters: Ints
    outcome: str
    reason: str | None
    fallback: Literal["none", "extended", "linear"] | None
    area: float
    gap: float | None
    foot: Floats | None
    normal: Floats | None
    gradient: Floats | None
    hessian: Floats | None


@dataclass(frozen=True)
class ContactFeet:
    """The feet of all s slaves with their first derivatives, for laws of the host's own.

    Slave k has the entries ``offsets[k]`` to ``offsets[k + 1]``, one for itself and one for each of its masters, in the
    order of ``Contact.gradient``; e are those of all slaves. So they are rows of sparse matrices over p nodes::

        at_foot = csr_matrix((feet.weights, feet.nodes, feet.offsets), shape=(s, p))  # at_foot @ field
        moves = bsr_matrix((feet.foot_jacobian, feet.nodes, feet.offsets), shape=(3 * s, 3 * p))

    Without contact gap, foot and normal are NaN, weights and derivatives 0; without a pairing the slave is alone.

    Attributes:
        offsets: where the entries of each slave begin, shape (s + 1,).
        nodes: of the entries, slave, master 1, …, master n, shape (e,).
        weights: φ, shape (e,): a field over the nodes is Σ φ_k u_k at the foot, Σ φ_k = 1; 0 at the slave's own entry.
            The foot is Σ φ_k x_k. Behind planes of symmetry the images of a node add to its weight, and their positions
            to the foot.
        gap: g, shape (s,), length.
        foot: x^d, shape (s, 3).
        normal: ν, unit normal at the foot, towards the outward side, shape (s, 3).
        foot_jacobian: ∂x^d/∂x by each entry's node, shape (e, 3, 3), row for the component of the foot; dimensionless.
        normal_jacobian: ∂ν/∂x, the same, 1/length.
        outcomes: as in ``Contacts``.

    """

    offsets: Ints
    nodes: Ints
    weights: Floats
    gap: Floats
    foot: Floats
    normal: Floats
    foot_jacobian: Floats
    normal_jacobian: Floats
    outcomes: list[str]

    @property
    def is_contact(self) -> NDArray[np.bool_]:
        """Which slaves have a result, shape (s,)."""
        return ~np.isnan(self.gap)


@dataclass(frozen=True)
class MaterialNodes:
    """Domains of influence of n masters in the first configuration, the positions the interface was made with.

    The domain of a master is an ellipsoid around its first position X. The slave has a place Ξ there, which moves with
    slave and masters; the domain itself stays what it is. Mirror images have domains of their own.

    Attributes:
        offsets: X − Ξ, shape (n, 3), length.
        metrics: upper triangles U, shape (n, 3, 3), 1/length: Ξ lies in the domain if |U (X − Ξ)| < 1.

    """

    offsets: Floats
    metrics: Floats

    @property
    def distances(self) -> Floats:
        """|U (X − Ξ)|, shape (n,): 0 at the master, 1 on the border of its domain."""
        return np.linalg.norm(np.einsum("kij,kj->ki", self.metrics, self.offsets), axis=1)


@dataclass(frozen=True)
class Pairing:
    """What one slave is paired with, at the positions of the moment.

    With domains of influence it is what lies within reach: fewer than ``Contact.masters``, the list of those that may
    come to, and mirror images are masters of their own.

    Attributes:
        positions: of the masters, or of the facet's corners (node to facet), shape (n, 3).
        masters: their nodes; None for node to facet (see ``Contact.masters``).
        frame: rows t1, t2 and outward normal, shape (3, 3); None for node to facet.
        support_radius: radius of the domain of influence, length; with the rule ``"domains"`` the distance of the
            farthest master, by which lengths are divided; None for node to facet.
        basis: ``"quadratic"`` or ``"linear"``; None for node to facet.
        material: with the rule ``"domains"`` the masters' domains, seen from the slave's place; else None.
        others: where a point lies on the line between two nodes, as in strips of one row of cells, the second node of
            each master, itself where it is a node; None if all are nodes or mirror images.
        parts: what that node has of the point, the rest is the master's; None beside ``others``.

    """

    positions: Floats
    masters: Ints | None = None
    frame: Floats | None = None
    support_radius: float | None = None
    basis: str | None = None
    material: MaterialNodes | None = None
    others: Ints | None = None
    parts: Floats | None = None


class CutBack(NamedTuple):
    """A hint how far to shorten an increment.

    ``factor`` is from 0.1 to 1, which means not at all; ``slave`` is the node that asks for it and ``outcome`` its
    outcome.
    """

    factor: float
    slave: int | None = None
    outcome: str | None = None


def unpacked(packed: Floats, size: int) -> Floats:
    """The symmetric matrix of a packed lower triangle, entry (i, j ≤ i) at i(i+1)/2 + j."""
    full = np.empty((size, size))
    rows, columns = np.tril_indices(size)
    full[rows, columns] = packed
    full[columns, rows] = packed
    return full
