//! From the gap to force and stiffness.

use diffuse_contact_kernels::support::{Vector, packed_row};

use super::{AssemblyError, ContactView, ElementView, Elements, NormalLaw, SlipView};
use crate::friction::{Coulomb, FrictionForce, NormalForce};

/// Which tangent is assembled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tangent {
    /// K = ε N Nᵀ − f M, the exact derivative −∂R/∂x (Chamoret et al. 2008, eq. 43). It is indefinite in general: in
    /// penetration −f M is negative along the directions in which the master surface is convex.
    #[default]
    Exact,
    /// K = ε N Nᵀ, positive semidefinite. Newton's method then converges linearly; no Hessian is needed. With friction
    /// c ∇²q + ∂c/∂q ∇q ∇qᵀ is added, which is symmetric but may be indefinite, and takes Hessians.
    GaussNewton,
}

impl Tangent {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Exact, Self::GaussNewton];
    /// Residual over force up to which [`adaptive`](Self::adaptive) gives the exact tangent.
    pub const ADAPTIVE_RATIO: f64 = 0.3;

    /// Name in options.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::GaussNewton => "gauss-newton",
        }
    }

    /// The tangent for the next linear solution of a Newton iteration.
    ///
    /// * `residual`: norm of the residual over the free degrees of freedom, contact included.
    /// * `force`: the largest norm among external forces, contact forces and reactions, at the same positions.
    ///
    /// [`Exact`](Self::Exact) if residual / force ≤ 0.3 or the residual is 0, else [`GaussNewton`](Self::GaussNewton); so it is for NaN.
    ///
    /// Contact forces of a trial state are ε times whatever penetrates, many times those of equilibrium. There −f M makes the stiffness
    /// indefinite, the more so the larger ε is, and steps lead nowhere. Near equilibrium −f M makes the iteration converge quadratically.
    /// A tangent is chosen when it is assembled: no evaluation is repeated.
    ///
    /// ```
    /// use diffuse_contact::assembly::{ContactLaw, Tangent};
    ///
    /// let law = ContactLaw::penalty(1e5);
    /// // In each iteration, between the residual and the stiffness:
    /// let (residual, force) = (4.0, 5.0);
    /// let law = law.with_tangent(Tangent::adaptive(residual, force));
    /// assert_eq!(law.tangent, Tangent::GaussNewton);
    /// ```
    #[must_use]
    pub fn adaptive(residual: f64, force: f64) -> Self {
        if residual == 0.0 || residual / force <= Self::ADAPTIVE_RATIO {
            Self::Exact
        } else {
            Self::GaussNewton
        }
    }
}

/// The law of contact: a normal law (penalty, augmented Lagrangian, or a [`NormalLaw`] of the user's own) and friction (none, or
/// [`Coulomb`] with a constant or a [`FrictionCoefficient`](crate::friction::FrictionCoefficient) of the user's own). It is the same over
/// nodes and over faces, where contact forces are pressures.
///
/// Contact force of element k, with ε_k = penalty × area_k:
///
/// ```text
/// f_k = λ_k − ε_k g_k        active if f_k > 0
/// R_k = f_k N_k              force on the nodes; −ε g N for λ = 0 (Chamoret et al. 2008, eq. 33)
/// K_k = ε_k N_k N_kᵀ − f_k M_k = −∂R_k/∂x; ε (g M + N Nᵀ) for λ = 0 (eq. 43)
/// ```
///
/// With a [`NormalLaw`] f_k = area_k p(g_k), and −area_k p′(g_k) stands in the place of ε_k.
///
/// An element with f_k ≤ 0 contributes nothing. At f_k = 0 exactly, such as a touching node with λ = 0, that is no force
/// and, of the two one-sided tangents, the one of the open side: zero.
///
/// With friction each element that carries force adds −c_k ∇q_k to R_k, see [`Coulomb`], and its derivative to K_k. K_k is then not
/// symmetric where the contact slides, and where it has closed since the last accepted step. Of that derivative
/// [`Tangent::GaussNewton`] keeps c ∇²q + ∂c/∂q ∇q ∇qᵀ, which is symmetric.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ContactLaw<'a> {
    /// Penalty ε_n > 0: force per length, or force per length³ if the elements carry areas. With a normal law of one's own it only
    /// estimates where a contact that closes in a step has touched: about the stiffness of that law in contact.
    pub penalty: f64,
    /// The normal law, if it is not the penalty's. It takes no multipliers.
    pub normal: Option<&'a dyn NormalLaw>,
    /// Multipliers λ_k ≥ 0 of the augmented Lagrangian, one contact force per element; `None` for λ = 0.
    pub multipliers: Option<&'a [f64]>,
    /// Which tangent is assembled.
    pub tangent: Tangent,
    /// Friction: the elements have to come with their slips.
    pub friction: Option<Coulomb<'a>>,
}

impl PartialEq for ContactLaw<'_> {
    /// Normal laws and coefficients of one's own are the same if they are one in memory.
    fn eq(&self, other: &Self) -> bool {
        let normal = match (self.normal, other.normal) {
            (Some(one), Some(other)) => std::ptr::addr_eq(one, other),
            (None, None) => true,
            _ => false,
        };
        let rest = |law: &Self| (law.penalty, law.multipliers, law.tangent, law.friction);
        normal && rest(self) == rest(other)
    }
}

impl<'a> ContactLaw<'a> {
    /// The penalty law with the exact tangent.
    #[must_use]
    pub const fn penalty(penalty: f64) -> Self {
        Self { penalty, normal: None, multipliers: None, tangent: Tangent::Exact, friction: None }
    }

    /// With this normal law, or the penalty's.
    #[must_use]
    pub const fn with_normal(self, normal: Option<&'a dyn NormalLaw>) -> Self {
        Self { normal, ..self }
    }

    /// With friction, or without. The tangential stiffness is one per area where the elements carry areas. A coefficient of 0 is no
    /// friction.
    #[must_use]
    pub fn with_friction(self, friction: Option<Coulomb<'a>>) -> Self {
        Self { friction: friction.filter(|friction| !friction.is_none()), ..self }
    }

    /// Whether tangents are symmetric.
    #[must_use]
    pub fn is_symmetric(&self) -> bool {
        self.friction.is_none() || self.tangent == Tangent::GaussNewton
    }

    /// With these multipliers, or without any.
    #[must_use]
    pub const fn with_multipliers(self, multipliers: Option<&'a [f64]>) -> Self {
        Self { multipliers, ..self }
    }

    /// With this tangent.
    #[must_use]
    pub const fn with_tangent(self, tangent: Tangent) -> Self {
        Self { tangent, ..self }
    }

    /// Contact force max(0, λ_k − ε_k g) of element `k` at the gap `gap`; with λ ← force it is also the update of the
    /// augmented Lagrangian. With a normal law of one's own area times its pressure, if that is positive.
    ///
    /// # Panics
    /// If there are multipliers, but none for `k`.
    #[must_use]
    pub fn force(&self, k: usize, gap: f64, area: f64) -> f64 {
        match self.normal {
            None => (self.multiplier(k) - self.penalty * area * gap).max(0.0),
            Some(normal) => (area * normal.pressure(k, gap).pressure).max(0.0),
        }
    }

    /// The normal force of element `k` at the gap `gap`, and −∂f/∂g.
    ///
    /// # Panics
    /// If there are multipliers, but none for `k`.
    #[must_use]
    pub fn normal_force(&self, k: usize, gap: f64, area: f64) -> NormalForce {
        match self.normal {
            None => NormalForce { force: self.force(k, gap, area), stiffness: self.penalty * area },
            Some(normal) => {
                let at = normal.pressure(k, gap);
                NormalForce { force: (area * at.pressure).max(0.0), stiffness: -area * at.by_gap }
            }
        }
    }

    /// The same of a gap and an area that are numbers, and of a law that may be none.
    pub(crate) fn checked_normal_force(
        &self,
        k: usize,
        gap: f64,
        area: f64,
    ) -> Result<NormalForce, AssemblyError> {
        let found = match self.normal {
            None => self.normal_force(k, gap, area),
            Some(normal) => {
                let at = normal.pressure(k, gap);
                if !(at.pressure.is_finite() && at.by_gap.is_finite()) {
                    let (pressure, by_gap) = (at.pressure, at.by_gap);
                    return Err(AssemblyError::InvalidPressure { element: k, gap, pressure, by_gap });
                }
                NormalForce { force: (area * at.pressure).max(0.0), stiffness: -area * at.by_gap }
            }
        };
        if found.stiffness.is_finite() && found.force.is_finite() {
            return Ok(found);
        }
        Err(AssemblyError::ForceOverflow { element: k, penalty: self.penalty, area, gap })
    }

    /// The friction of element `k` with this slip; `None` without friction, and before there is an anchor.
    #[must_use]
    pub fn friction_of(
        &self,
        k: usize,
        gap: f64,
        area: f64,
        slip: Option<SlipView<'_>>,
    ) -> Option<FrictionForce> {
        let slip = slip.filter(|slip| !slip.gradient.is_empty())?;
        self.friction_by(self.normal_force(k, gap, area), area, (slip.half_square, slip.opening))
    }

    /// The friction of an element with this normal force, half square of its slip, and the gap that it was open by.
    pub(crate) fn friction_by(
        &self,
        normal: NormalForce,
        area: f64,
        (half_square, opening): (f64, f64),
    ) -> Option<FrictionForce> {
        let opening = self.penalty * area * opening;
        Some(self.friction?.over(area).force_since(normal, half_square, opening))
    }

    /// Checks the penalty, and that there are no multipliers or one that is finite and not negative for each of `elements`
    /// elements.
    ///
    /// # Errors
    /// [`AssemblyError::InvalidPenalty`], [`AssemblyError::MultiplierCount`], [`AssemblyError::InvalidMultiplier`],
    /// [`AssemblyError::MultipliersOfOwnLaw`].
    pub fn validate(&self, elements: usize) -> Result<(), AssemblyError> {
        self.check(elements)?;
        (0..elements).try_for_each(|k| self.check_multiplier(k))
    }

    /// As [`validate`](Self::validate), and that `elements` can have the friction that the law has.
    ///
    /// # Errors
    /// As [`validate`](Self::validate) and [`Elements::check_friction`].
    pub fn validate_for<E: Elements + ?Sized>(&self, elements: &E) -> Result<(), AssemblyError> {
        self.check_for(elements)?;
        (0..elements.len()).try_for_each(|k| self.check_multiplier(k))
    }

    /// Checks all of the law but the multipliers' values, for these elements.
    pub(super) fn check_for<E: Elements + ?Sized>(&self, elements: &E) -> Result<(), AssemblyError> {
        self.check(elements.len())?;
        if self.friction.is_some() { elements.check_friction() } else { Ok(()) }
    }

    fn multiplier(&self, k: usize) -> f64 {
        self.multipliers.map_or(0.0, |multipliers| multipliers[k])
    }

    /// Checks the penalty and the number of multipliers.
    pub(super) fn check(&self, elements: usize) -> Result<(), AssemblyError> {
        if !(self.penalty > 0.0 && self.penalty.is_finite()) {
            return Err(AssemblyError::InvalidPenalty { value: self.penalty });
        }
        if self.normal.is_some() && self.multipliers.is_some() {
            return Err(AssemblyError::MultipliersOfOwnLaw);
        }
        match self.multipliers {
            Some(multipliers) if multipliers.len() != elements => {
                Err(AssemblyError::MultiplierCount { found: multipliers.len(), elements })
            }
            _ => Ok(()),
        }
    }

    /// Checks the contact quantities of an element, those of its derivatives only if it is active.
    pub(super) fn check_element(
        &self,
        k: usize,
        element: &ElementView<'_>,
        needs: Needs,
    ) -> Result<(), AssemblyError> {
        self.check_multiplier(k)?;
        let Some(contact) = &element.contact else { return Ok(()) };
        if element.masters.is_empty() {
            return Err(AssemblyError::NoMasters { element: k });
        }
        self.check_contact(k, contact, 3 * element.node_count(), needs)
    }

    fn check_multiplier(&self, k: usize) -> Result<(), AssemblyError> {
        let value = self.multiplier(k);
        let is_sound = value >= 0.0 && value.is_finite();
        if is_sound { Ok(()) } else { Err(AssemblyError::InvalidMultiplier { element: k, value }) }
    }

    /// Checks the contact quantities of an element with so many degrees of freedom.
    pub(super) fn check_contact(
        &self,
        k: usize,
        contact: &ContactView<'_>,
        freedoms: usize,
        needs: Needs,
    ) -> Result<(), AssemblyError> {
        self.check_multiplier(k)?;
        if !contact.gap.is_finite() {
            return Err(AssemblyError::InvalidGap { element: k, value: contact.gap });
        }
        if !(contact.area >= 0.0 && contact.area.is_finite()) {
            return Err(AssemblyError::InvalidArea { element: k, value: contact.area });
        }
        let normal = self.checked_normal_force(k, contact.gap, contact.area)?;
        if !(normal.force > 0.0) {
            return Ok(());
        }
        let length = |what, found, expected| {
            let wrong = AssemblyError::DerivativeLength { what, element: k, found, expected };
            if found == expected { Ok(()) } else { Err(wrong) }
        };
        length("gradient", contact.gradient.len(), freedoms)?;
        let packed = freedoms * (freedoms + 1) / 2;
        if needs == Needs::Tangent && self.tangent == Tangent::Exact {
            length("Hessian", contact.hessian.len(), packed)?;
        }
        if self.friction.is_none() {
            return Ok(());
        }
        let slip = contact.slip.ok_or(AssemblyError::NoSlip { element: k })?;
        if slip.gradient.is_empty() {
            return Ok(());
        }
        length("gradient of the slip", slip.gradient.len(), freedoms)?;
        if needs == Needs::Tangent {
            length("Hessian of the slip", slip.hessian.len(), packed)?;
        }
        let SlipView { half_square, opening, .. } = slip;
        let friction = self.friction_by(normal, contact.area, (half_square, opening));
        let is_finite = half_square.is_finite() && friction.is_none_or(|force| force.check().is_ok());
        let invalid = AssemblyError::InvalidSlip { element: k, half_square, opening };
        if is_finite { Ok(()) } else { Err(invalid) }
    }

    /// What element `k` contributes; `None` if that is nothing. The element is one that passes
    /// [`check_element`](Self::check_element).
    pub(super) fn active<'e, E: Elements + ?Sized>(&self, elements: &'e E, k: usize) -> Option<Active<'e>> {
        self.active_contact(k, &elements.element(k).contact?)
    }

    /// What an element with these contact quantities contributes.
    pub(super) fn active_contact<'e>(&self, k: usize, contact: &ContactView<'e>) -> Option<Active<'e>> {
        let normal @ NormalForce { force, stiffness } = self.normal_force(k, contact.gap, contact.area);
        if !(force > 0.0) {
            return None;
        }
        let hessian = match self.tangent {
            Tangent::Exact => Some(contact.hessian),
            Tangent::GaussNewton => None,
        };
        let tracked = contact.slip.filter(|slip| !slip.gradient.is_empty());
        let friction = tracked.and_then(|slip| {
            let force = self.friction_by(normal, contact.area, (slip.half_square, slip.opening))?;
            let factor_by_gap = if self.is_symmetric() { 0.0 } else { force.factor_by_gap };
            Some(ActiveFriction { force: FrictionForce { factor_by_gap, ..force }, slip })
        });
        Some(Active { force, stiffness, gradient: contact.gradient, hessian, friction })
    }
}

/// What is assembled from an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Needs {
    Residual,
    Tangent,
}

/// An element that carries force.
#[derive(Clone, Copy, Debug)]
pub(super) struct Active<'a> {
    /// f, force.
    pub force: f64,
    /// ε, force per length.
    stiffness: f64,
    /// N.
    pub gradient: &'a [f64],
    /// M, packed lower triangle, if it takes part.
    hessian: Option<&'a [f64]>,
    friction: Option<ActiveFriction<'a>>,
}

/// The friction of an element that carries force.
#[derive(Clone, Copy, Debug)]
struct ActiveFriction<'a> {
    force: FrictionForce,
    slip: SlipView<'a>,
}

/// What is not symmetric in the tangent of an element: a factor times ∇q Nᵀ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Skew<'a> {
    pub factor: f64,
    /// ∇q.
    pub slip: &'a [f64],
}

impl<'a> Active<'a> {
    /// ε, a symmetric rest, and what is not symmetric: together the tangent.
    pub fn split(self) -> (f64, Self, Option<Skew<'a>>) {
        let skew = self.friction.filter(|friction| friction.force.factor_by_gap != 0.0);
        let skew =
            skew.map(|friction| Skew { factor: friction.force.factor_by_gap, slip: friction.slip.gradient });
        let without = |friction: ActiveFriction<'a>| ActiveFriction {
            force: FrictionForce { factor_by_gap: 0.0, ..friction.force },
            ..friction
        };
        (self.stiffness, Self { stiffness: 0.0, friction: self.friction.map(without), ..self }, skew)
    }
}

impl Active<'_> {
    /// Entry p of the contact force.
    pub fn contact_force(&self, p: usize) -> f64 {
        let normal = self.force * self.gradient[p];
        self.friction.map_or(normal, |friction| normal - friction.force.factor * friction.slip.gradient[p])
    }

    /// Looks at M from one end to the other, so that the processor fetches it in order: columns of a packed triangle are far apart.
    pub fn look(&self) {
        let bits = |bits, number: &f64| bits ^ number.to_bits();
        std::hint::black_box(self.hessian.unwrap_or_default().iter().step_by(8).fold(0, bits));
    }

    /// Number of nodes.
    pub const fn nodes(&self) -> usize {
        self.gradient.len() / 3
    }

    /// Whether the tangent is symmetric.
    pub fn is_symmetric(&self) -> bool {
        self.friction.is_none_or(|friction| friction.force.factor_by_gap == 0.0)
    }

    /// Entry (p, q) of the tangent; without friction the same number as entry (q, p).
    pub fn tangent(&self, p: usize, q: usize) -> f64 {
        let (row, column) = if p >= q { (p, q) } else { (q, p) };
        let rank_one = self.stiffness * (self.gradient[p] * self.gradient[q]);
        let normal = match self.hessian {
            Some(hessian) => rank_one - self.force * hessian[row * (row + 1) / 2 + column],
            None => rank_one,
        };
        let Some(ActiveFriction { force, slip }) = &self.friction else { return normal };
        let [own, other] = [p, q].map(|p| slip.gradient[p]);
        let second = slip.hessian[row * (row + 1) / 2 + column];
        normal + force.tangent_entry([own, other], second, self.gradient[q])
    }

    /// Writes the rows of the element's node `a`, 3(n+1) entries each: the same numbers as [`tangent`](Self::tangent).
    #[inline(always)]
    pub fn rows<T: Vector>(&self, a: usize, rows: [&mut [f64]; 3]) {
        let freedoms = self.gradient.len();
        let [x, y, z] = rows.map(|row| &mut row[..freedoms]);
        let (stiffness, force) = (self.stiffness, self.force);
        for (i, row) in [&mut *x, &mut *y, &mut *z].into_iter().enumerate() {
            let p = 3 * a + i;
            let own = self.gradient[p];
            match (self.hessian, &self.friction) {
                // Up to the diagonal they are rows of the lower triangle, …
                (Some(hessian), None) => {
                    let seconds = &hessian[packed_row(p)..][..=p];
                    for ((entry, other), second) in row.iter_mut().zip(self.gradient).zip(seconds) {
                        *entry = stiffness * (own * other) - force * second;
                    }
                }
                (None, None) => {
                    for (entry, other) in row.iter_mut().zip(self.gradient) {
                        *entry = stiffness * (own * other);
                    }
                }
                _ => row.iter_mut().enumerate().for_each(|(q, entry)| *entry = self.tangent(p, q)),
            }
        }
        let (Some(hessian), None) = (self.hessian, &self.friction) else { return };
        // … and after it columns.
        let (p, own) = (3 * a, [0, 1, 2].map(|i| self.gradient[3 * a + i]));
        let entry = |i: usize, other: f64, second: f64| stiffness * (own[i] * other) - force * second;
        let second = |row: usize, column: usize| hessian[packed_row(row) + column];
        x[p + 1] = entry(0, own[1], second(p + 1, p));
        x[p + 2] = entry(0, own[2], second(p + 2, p));
        y[p + 2] = entry(1, own[2], second(p + 2, p + 1));
        let mut q = p + 3;
        if T::WIDTH == 4 {
            while q + 4 <= freedoms {
                let mut columns = [T::ZERO; 4];
                for k in 0..4 {
                    columns[k] = self.column(q + k, p);
                }
                let mut targets = [&mut x[q..q + 4], &mut y[q..q + 4], &mut z[q..q + 4]];
                T::store_transposed(&columns, &mut targets, |target| &mut **target);
                q += 4;
            }
        }
        for q in q..freedoms {
            let (other, start) = (self.gradient[q], packed_row(q) + p);
            let seconds = &hessian[start..start + 3];
            x[q] = entry(0, other, seconds[0]);
            y[q] = entry(1, other, seconds[1]);
            z[q] = entry(2, other, seconds[2]);
        }
    }

    /// Entries (q, p) to (q, p + 2) of the tangent without friction, and one more: row q has it, as it belongs to a later node.
    #[inline(always)]
    fn column<T: Vector>(&self, q: usize, p: usize) -> T {
        let own = T::load(self.gradient, p) * T::splat(self.gradient[q]);
        let second = T::load(self.hessian.unwrap_or_default(), packed_row(q) + p);
        T::splat(self.stiffness) * own - T::splat(self.force) * second
    }

    /// Entries (p, 0) … (p, p) of the tangent, and whether all are finite. The same numbers as [`tangent`](Self::tangent).
    pub fn tangent_row(&self, p: usize, row: &mut [f64]) -> bool {
        if self.friction.is_some() {
            let mut is_finite = true;
            for (q, entry) in row.iter_mut().enumerate() {
                *entry = self.tangent(p, q);
                is_finite &= entry.is_finite();
            }
            return is_finite;
        }
        let (stiffness, force, own) = (self.stiffness, self.force, self.gradient[p]);
        let entries = row.iter_mut().zip(&self.gradient[..=p]);
        let mut is_finite = true;
        match self.hessian {
            Some(hessian) => {
                for ((entry, other), second) in entries.zip(&hessian[p * (p + 1) / 2..][..=p]) {
                    *entry = stiffness * (own * other) - force * second;
                    is_finite &= entry.is_finite();
                }
            }
            None => {
                for (entry, other) in entries {
                    *entry = stiffness * (own * other);
                    is_finite &= entry.is_finite();
                }
            }
        }
        is_finite
    }

    /// The error of a tangent that is not finite: its first equation that is not.
    pub fn overflow(&self) -> AssemblyError {
        let freedoms = self.gradient.len();
        let is_sound = |p: usize| (0..freedoms).all(|q| self.tangent(p, q).is_finite());
        let equation = (0..freedoms).find(|&p| !is_sound(p)).unwrap_or(0);
        AssemblyError::Overflow { what: "values", equation }
    }
}

/// Checks the law and all elements, also that their nodes are among the first `nodes`.
pub(super) fn check<E: Elements + ?Sized>(
    elements: &E,
    law: &ContactLaw<'_>,
    nodes: usize,
    needs: Needs,
) -> Result<(), AssemblyError> {
    law.check_for(elements)?;
    for k in 0..elements.len() {
        let element = elements.element(k);
        if let Some(node) = element.nodes().find(|&node| node >= nodes) {
            return Err(AssemblyError::UnknownNode { element: k, node, nodes });
        }
        law.check_element(k, &element, needs)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_adaptive_tangent_is_exact_up_to_its_ratio() {
        let ratio = Tangent::ADAPTIVE_RATIO;
        for force in [1e-300, 0.7, 1.0, 3e5, 1e300] {
            assert_eq!(Tangent::adaptive(0.0, force), Tangent::Exact);
            assert_eq!(Tangent::adaptive(0.999 * ratio * force, force), Tangent::Exact);
            assert_eq!(Tangent::adaptive(1.001 * ratio * force, force), Tangent::GaussNewton);
        }
        assert_eq!(Tangent::adaptive(ratio, 1.0), Tangent::Exact);
        assert_eq!(Tangent::adaptive(ratio.next_up(), 1.0), Tangent::GaussNewton);
    }

    #[test]
    fn without_forces_or_numbers_the_adaptive_tangent_has_no_hessian() {
        assert_eq!(Tangent::adaptive(0.0, 0.0), Tangent::Exact);
        for [residual, force] in [
            [1.0, 0.0],
            [f64::INFINITY, 1.0],
            [f64::INFINITY, f64::INFINITY],
            [f64::NAN, 1.0],
            [1.0, f64::NAN],
            [f64::NAN, f64::NAN],
        ] {
            assert_eq!(Tangent::adaptive(residual, force), Tangent::GaussNewton, "{residual} {force}");
        }
    }
}
