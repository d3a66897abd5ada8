//! The friction of one contact, and what becomes of its slip.

use crate::vector::Vector3;
use crate::{ElementError, Point, Slip};

/// What a contact with friction does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum FrictionState {
    /// No pressure, or no history yet: no friction.
    #[default]
    Open,
    /// The traction is below μ p.
    Stick,
    /// The traction is μ p, against the slip.
    Slip,
}

impl FrictionState {
    /// Name in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Stick => "stick",
            Self::Slip => "slip",
        }
    }
}

/// What a contact did when the last step was accepted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BeforeStep {
    /// It carried nothing.
    Open,
    /// It stuck, and could have borne this friction: force, over faces force per area.
    Stuck(f64),
    /// It slid, with this friction.
    Slid(f64),
}

/// The normal force of a contact and how it depends on the gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalForce {
    /// p ≥ 0, force.
    pub force: f64,
    /// −∂p/∂g ≥ 0, force per length: ε.
    pub stiffness: f64,
}

/// The friction of one contact: the factor c of R = −c ∇q, and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionForce {
    /// Stick, slip or neither.
    pub state: FrictionState,
    /// c, force per length.
    pub factor: f64,
    /// ∂c/∂q, force per length³.
    pub factor_by_half_square: f64,
    /// ∂c/∂g, force per length².
    pub factor_by_gap: f64,
    /// w, the part of the slip since the place of touch.
    pub share: f64,
    /// Part of the slip that remains behind the slave when the step is accepted, 1 − θ = c/ε_T: w in stick, which is 1
    /// if the contact was closed before.
    pub kept: f64,
}

/// The friction of a node of the faces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceTraction {
    /// P_n d, length.
    pub slip: Point,
    /// t_A, force per area.
    pub traction: Point,
    /// Its rows by way, normal and pressure, 3 × 7.
    pub jacobian: [f64; 21],
    pub sliding: Sliding,
}

/// What a contact does with its slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sliding {
    pub state: FrictionState,
    /// c, force per length, with areas per area.
    pub factor: f64,
    /// w
    pub share: f64,
    /// 1 − θ
    pub kept: f64,
}

impl Sliding {
    /// Of a contact without pressure.
    pub const OPEN: Self = Self { state: FrictionState::Open, factor: 0.0, share: 1.0, kept: 1.0 };

    /// By how much the slip since where the contact stuck is none that the traction allows, length: all of it in stick, and what is not
    /// along the traction in slip. `elastic`: the slip that the law has.
    pub fn error(&self, elastic: Vector3, since_stuck: Vector3) -> f64 {
        let slid = since_stuck * self.share;
        let along = match self.state {
            FrictionState::Slip => elastic.try_normalize(),
            FrictionState::Open | FrictionState::Stick => None,
        };
        let allowed = along.map_or(Vector3::zeros(), |along| along * along.dot(&slid).max(0.0));
        (slid - allowed).norm()
    }

    /// As [`FrictionForce::dissipated`], with areas per area.
    pub fn dissipated(&self, slip: f64, before: BeforeStep) -> f64 {
        let traction = self.factor * slip;
        match (self.state, before) {
            (FrictionState::Slip, before) => {
                let first = match before {
                    BeforeStep::Open => 0.0,
                    BeforeStep::Stuck(limit) | BeforeStep::Slid(limit) => limit,
                };
                0.5 * (first + traction) * ((1.0 - self.kept) * slip)
            }
            (FrictionState::Open, BeforeStep::Slid(traction)) => 0.5 * traction * slip,
            (FrictionState::Open | FrictionState::Stick, _) => 0.0,
        }
    }
}

impl FrictionForce {
    pub(super) const NONE: Self = Self {
        state: FrictionState::Open,
        factor: 0.0,
        factor_by_half_square: 0.0,
        factor_by_gap: 0.0,
        share: 1.0,
        kept: 1.0,
    };

    /// Work of the traction over what slid since the last step was accepted, for a slip s, energy, by the trapezoidal rule. Of a contact that
    /// closes, or slid and opens, it is half of the traction times the whole way, whatever part of that was in touch: so the work of contacts
    /// that come and go adds up on average, however long the steps are.
    pub fn dissipated(&self, slip: f64, before: BeforeStep) -> f64 {
        self.sliding().dissipated(slip, before)
    }

    pub(crate) const fn sliding(&self) -> Sliding {
        let Self { state, factor, share, kept, .. } = *self;
        Sliding { state, factor, share, kept }
    }

    /// R = −c ∇q, the force on slave, masters and anchor, 3(n+2) entries.
    pub fn contact_force(&self, slip: &Slip) -> Vec<f64> {
        slip.gradient.iter().map(|x| -self.factor * x).collect()
    }

    /// K = −∂R/∂x = c ∇²q + ∂c/∂q ∇q ∇qᵀ + ∂c/∂g ∇q Nᵀ, rows of 3(n+2) entries over slave, masters and anchor. The last term is not
    /// symmetric; it is zero in stick, unless the contact has closed since the last accepted step.
    ///
    /// # Panics
    /// If the slip has no Hessian.
    pub fn tangent(&self, slip: &Slip) -> Vec<Vec<f64>> {
        let size = slip.gradient.len();
        assert_eq!(slip.hessian.size(), size, "a slip with its Hessian");
        // The gap does not depend on the anchor.
        let by_gap = |q: usize| slip.contact.gradient.get(q).copied().unwrap_or(0.0);
        let entry = |p: usize, q: usize| {
            let [own, other] = [p, q].map(|p| slip.gradient[p]);
            self.tangent_entry([own, other], slip.hessian.get(p, q), by_gap(q))
        };
        (0..size).map(|p| (0..size).map(|q| entry(p, q)).collect()).collect()
    }

    /// Entry (p, q) of the tangent from ∇q at p and q, ∇²q at (p, q) and N at q.
    pub(crate) fn tangent_entry(&self, [own, other]: [f64; 2], second: f64, by_gap: f64) -> f64 {
        // The product of a pair is the same either way round: without the last term the tangent is symmetric to the last bit.
        let symmetric = self.factor * second + self.factor_by_half_square * (own * other);
        symmetric + self.factor_by_gap * own * by_gap
    }

    /// Whether the force and its derivatives are finite.
    ///
    /// # Errors
    /// [`ElementError::Overflow`].
    pub fn check(&self) -> Result<(), ElementError> {
        let all = [self.factor, self.factor_by_half_square, self.factor_by_gap, self.kept];
        let is_finite = all.iter().all(|x| x.is_finite());
        if is_finite { Ok(()) } else { Err(ElementError::Overflow { what: "friction" }) }
    }
}
