//! From the gap to force and stiffness.

use super::active::{Active, ActiveFriction};
use super::{
    AssemblyError, ContactView, ElementView, Elements, NormalLaw, NormalPressure, SlipView, Tangent,
};
use crate::friction::{CoefficientValue, Coulomb, FrictionForce, NormalForce};
use crate::with::with;

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
    pub const fn penalty(penalty: f64) -> Self {
        Self { penalty, normal: None, multipliers: None, tangent: Tangent::Exact, friction: None }
    }

    /// With friction, or without. The tangential stiffness is one per area where the elements carry areas. A coefficient of 0 is no
    /// friction.
    #[must_use]
    pub fn with_friction(self, friction: Option<Coulomb<'a>>) -> Self {
        Self { friction: friction.filter(|friction| !friction.is_none()), ..self }
    }

    /// Whether tangents are symmetric.
    pub fn is_symmetric(&self) -> bool {
        self.friction.is_none() || self.tangent == Tangent::GaussNewton
    }

    with! {
        /// With this normal law, or the penalty's.
        with_normal(normal: Option<&'a dyn NormalLaw>);
        /// With these multipliers, or without any.
        with_multipliers(multipliers: Option<&'a [f64]>);
        /// With this tangent.
        with_tangent(tangent: Tangent);
    }

    /// Contact force max(0, λ_k − ε_k g) of element `k` at the gap `gap`; with λ ← force it is also the update of the
    /// augmented Lagrangian. With a normal law of one's own area times its pressure, if that is positive.
    ///
    /// # Panics
    /// If there are multipliers, but none for `k`.
    pub fn force(&self, k: usize, gap: f64, area: f64) -> f64 {
        self.normal_force(k, gap, area).force
    }

    /// The normal force of element `k` at the gap `gap`, and −∂f/∂g.
    ///
    /// # Panics
    /// If there are multipliers, but none for `k`.
    pub fn normal_force(&self, k: usize, gap: f64, area: f64) -> NormalForce {
        self.force_with(self.multiplier(k), k, gap, area).0
    }

    /// The normal force with this multiplier, and what it was made of by a normal law of one's own.
    fn force_with(
        &self,
        multiplier: f64,
        k: usize,
        gap: f64,
        area: f64,
    ) -> (NormalForce, Option<NormalPressure>) {
        let Some(normal) = self.normal else {
            let stiffness = self.penalty * area;
            let force = (multiplier - stiffness * gap).max(0.0);
            return (NormalForce { force, stiffness }, None);
        };
        let at = normal.pressure(k, gap);
        let force = area * at.pressure;
        // What is no number stays none.
        let force = if force > 0.0 || force.is_nan() { force } else { 0.0 };
        (NormalForce { force, stiffness: -area * at.by_gap }, Some(at))
    }

    /// [`normal_force`](Self::normal_force) of a gap and an area that are numbers, by a law that may give none.
    ///
    /// # Errors
    /// [`AssemblyError::InvalidPressure`] of a normal law, [`AssemblyError::ForceOverflow`].
    ///
    /// # Panics
    /// If there are multipliers, but none for `k`.
    pub fn checked_normal_force(&self, k: usize, gap: f64, area: f64) -> Result<NormalForce, AssemblyError> {
        self.checked_force_with(self.multiplier(k), k, gap, area)
    }

    /// The same with this multiplier.
    pub(crate) fn checked_force_with(
        &self,
        multiplier: f64,
        k: usize,
        gap: f64,
        area: f64,
    ) -> Result<NormalForce, AssemblyError> {
        let (found, own) = self.force_with(multiplier, k, gap, area);
        if let Some(NormalPressure { pressure, by_gap }) = own
            && !(pressure.is_finite() && by_gap.is_finite())
        {
            return Err(AssemblyError::InvalidPressure { element: k, gap, pressure, by_gap });
        }
        if found.stiffness.is_finite() && found.force.is_finite() {
            return Ok(found);
        }
        Err(AssemblyError::ForceOverflow { element: k, penalty: self.penalty, area, gap })
    }

    /// How far a contact without force is from carrying some at this gap, length.
    pub(crate) fn opening(&self, k: usize, gap: f64) -> Result<f64, AssemblyError> {
        let onset = self.normal.map_or(0.0, |normal| normal.onset(k));
        if onset.is_finite() {
            Ok((gap - onset).max(0.0))
        } else {
            Err(AssemblyError::InvalidOnset { element: k, value: onset })
        }
    }

    /// The friction of element `k` with this slip; `None` without friction, and before there is an anchor.
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

    /// The friction of an element with this normal force, half square of its slip, and what it was open by.
    pub(crate) fn friction_by(
        &self,
        normal: NormalForce,
        area: f64,
        (half_square, opening): (f64, f64),
    ) -> Option<FrictionForce> {
        let opening = self.penalty * area * opening;
        Some(self.friction?.over(area).force_since(normal, half_square, opening))
    }

    /// Why the friction of element `k` is none: its coefficient, or its slip. `friction`: the law over the area that the pressure and the
    /// share belong to.
    pub(crate) fn invalid_friction(
        friction: &Coulomb<'_>,
        k: usize,
        (pressure, share): (f64, f64),
        (half_square, opening): (f64, f64),
    ) -> AssemblyError {
        match friction.unsound_coefficient(pressure, (2.0 * half_square).sqrt(), share) {
            Some(([pressure, rate], CoefficientValue { value, by_pressure, by_rate })) => {
                AssemblyError::InvalidCoefficient { element: k, pressure, rate, value, by_pressure, by_rate }
            }
            None => AssemblyError::InvalidSlip { element: k, half_square, opening },
        }
    }

    /// Why [`friction_by`](Self::friction_by) is none.
    pub(crate) fn invalid_friction_by(
        &self,
        k: usize,
        normal: NormalForce,
        area: f64,
        (half_square, opening): (f64, f64),
    ) -> AssemblyError {
        let invalid = AssemblyError::InvalidSlip { element: k, half_square, opening };
        let Some(friction) = &self.friction else { return invalid };
        let share = normal.force / (normal.force + self.penalty * area * opening);
        Self::invalid_friction(&friction.over(area), k, (normal.force, share), (half_square, opening))
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

    pub(crate) fn multiplier(&self, k: usize) -> f64 {
        self.multipliers.map_or(0.0, |multipliers| multipliers[k])
    }

    /// Checks the penalty and the number of multipliers.
    pub(super) fn check(&self, elements: usize) -> Result<(), AssemblyError> {
        if !(self.penalty > 0.0 && self.penalty.is_finite()) {
            return Err(AssemblyError::InvalidPenalty { value: self.penalty });
        }
        // None for no elements are those of a rank without slaves.
        if self.normal.is_some() && self.multipliers.is_some_and(|own| elements > 0 || !own.is_empty()) {
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
        let slip = (half_square, opening);
        if is_finite { Ok(()) } else { Err(self.invalid_friction_by(k, normal, contact.area, slip)) }
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
