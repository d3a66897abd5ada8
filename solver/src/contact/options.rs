//! How two surfaces interact.

use std::sync::Arc;

use crate::named::named;
use diffuse_contact::assembly::Tangent;
use diffuse_contact::faces::{FacePressures, FaceRule, QuadraticFace};
use diffuse_contact::friction::{DecayingCoefficient, TabulatedCoefficient};
use diffuse_contact::interface::InterfaceOptions;
use diffuse_contact::surface::SymmetryPlane;

/// Functions that give options another value of one field.
macro_rules! with {
    ($($(#[$doc:meta])+ $function:ident($field:ident: $type:ty);)+) => {$(
        $(#[$doc])+
        #[must_use]
        pub fn $function(self, $field: $type) -> Self {
            Self { $field, ..self }
        }
    )+};
}

/// What contact is integrated over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Integration {
    /// The slave's nodes, one force each: the energy form, symmetric and conservative.
    #[default]
    Nodes,
    /// The slave's faces: passes the patch test, its tangent is not symmetric.
    Faces {
        /// How many points each piece of a face has.
        rule: FaceRule,
        /// Where the pressure follows from the gap.
        pressures: FacePressures,
    },
}

impl Integration {
    /// Faces by the rule of second degree, with pressures averaged to their nodes.
    pub const FACES: Self = Self::Faces { rule: FaceRule::Second, pressures: FacePressures::Nodes };
}

/// When slaves are paired anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RefreshRule {
    /// At the beginning of an increment, at the positions the last one ended with.
    #[default]
    Increment,
    /// At the beginning of an increment and of every iteration.
    Iteration,
}

named!(RefreshRule { Increment => "increment", Iteration => "iteration" });

/// Which tangent of contact a linear solution has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TangentRule {
    /// The exact one near equilibrium, ε N Nᵀ alone far from it: [`Tangent::adaptive`].
    #[default]
    Adaptive,
    /// Always ε N Nᵀ − f M (Chamoret et al. 2008, eq. 43).
    Exact,
    /// Always ε N Nᵀ.
    GaussNewton,
}

named!(TangentRule {
    Adaptive => "adaptive",
    Exact => Tangent::Exact.name(),
    GaussNewton => Tangent::GaussNewton.name(),
});

impl TangentRule {
    /// The tangent at a state with these norms of the residual and of the forces.
    pub fn at(self, residual: f64, force: f64) -> Tangent {
        match self {
            Self::Adaptive => Tangent::adaptive(residual, force),
            Self::Exact => Tangent::Exact,
            Self::GaussNewton => Tangent::GaussNewton,
        }
    }
}

/// Rounds of Uzawa's iteration: when an increment has converged, λ ← max(0, λ − ε g), and it is solved again, until every contact
/// that carries force is closed and no other one penetrates. Those of friction: tractions become multipliers, until slips are those that
/// Coulomb's law allows.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Augmentation {
    /// |g| of contacts that carry force, and −g of others, that ends the rounds, length; of friction the slip that should not be.
    pub tolerance: f64,
    /// Most rounds in an increment, at least 1.
    pub max_rounds: usize,
}

impl Augmentation {
    /// Up to ten rounds, until gaps are within a tolerance.
    pub const fn new(tolerance: f64) -> Self {
        Self { tolerance, max_rounds: 10 }
    }

    with! {
        /// With so many rounds at most.
        with_max_rounds(max_rounds: usize);
    }
}

/// μ
#[derive(Clone, Debug, PartialEq)]
pub enum Coefficient {
    /// The same for all contacts, ≥ 0; 0 is no friction.
    Constant(f64),
    /// It decays from rest to fast sliding.
    Decaying(DecayingCoefficient),
    /// By pressure and slip rate.
    Tabulated(Arc<TabulatedCoefficient>),
}

/// Coulomb friction between two surfaces.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Friction {
    /// μ
    pub coefficient: Coefficient,
    /// ε_T, force per slip of a slave node that sticks, with areas force per area and slip; `None`: as large as the penalty.
    pub stiffness: Option<f64>,
    /// τ > 0, which no slave node exceeds, force, with areas and over faces force per area; `None`: none.
    pub shear_limit: Option<f64>,
    /// Whether the tangent leaves out what is not symmetric: linear systems are solved in half of the time, and it takes more of them.
    pub is_symmetric: bool,
    /// Rounds that take the slip of slaves that stick away; `None`: they creep by their elastic slip.
    pub augmentation: Option<Augmentation>,
}

impl Friction {
    /// With this coefficient, a stiffness as large as the penalty, the exact tangent, and without augmentation.
    pub const fn new(coefficient: Coefficient) -> Self {
        Self { coefficient, stiffness: None, shear_limit: None, is_symmetric: false, augmentation: None }
    }

    with! {
        /// With augmentation, or without.
        with_augmentation(augmentation: Option<Augmentation>);
        /// With this tangential stiffness, or the penalty's.
        with_stiffness(stiffness: Option<f64>);
        /// With this shear limit, or none.
        with_shear_limit(shear_limit: Option<f64>);
        /// With the symmetric part of the tangent only, or all of it.
        with_symmetric_tangent(is_symmetric: bool);
    }
}

/// How two surfaces interact.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct InteractionOptions {
    /// Its name in the deck.
    pub name: String,
    /// ε > 0: force per length and slave node, or force per length³ if the interface carries areas. In a two-pass interaction each
    /// pass gets half of it.
    pub penalty: f64,
    /// Augmented Lagrangian; `None`: penalty alone.
    pub augmentation: Option<Augmentation>,
    /// When slaves are paired anew.
    pub refresh: RefreshRule,
    /// The exact tangent, ε N Nᵀ alone, or the one or the other by the residual.
    pub tangent: TangentRule,
    /// Whether the surfaces are also paired the other way round.
    pub two_pass: bool,
    /// Whether master and slave are one surface, in contact with itself. Its nodes get half of the penalty each, as those of two passes.
    pub self_contact: bool,
    /// Element and pairing.
    pub interface: InterfaceOptions,
    /// Planes in which the master goes on as its mirror image.
    pub symmetry: Vec<SymmetryPlane>,
    /// Coulomb friction.
    pub friction: Option<Friction>,
    /// What contact is integrated over. Over faces, which are cut in every iteration, the penalty is per area.
    pub integration: Integration,
    /// Faces of second order that facets of either surface are parts of: over faces they carry the forces.
    pub quadratic_faces: Vec<QuadraticFace>,
    /// The gap up to which slaves were moved into touch before the start, length; only told on.
    pub adjust: Option<f64>,
}

impl InteractionOptions {
    /// Penalty alone, paired at the beginning of an increment, with the adaptive tangent, one pass, the default element and no
    /// planes of symmetry.
    pub fn new(name: impl Into<String>, penalty: f64) -> Self {
        Self {
            name: name.into(),
            penalty,
            augmentation: None,
            refresh: RefreshRule::default(),
            tangent: TangentRule::default(),
            two_pass: false,
            self_contact: false,
            interface: InterfaceOptions::default(),
            symmetry: Vec::new(),
            friction: None,
            integration: Integration::default(),
            quadratic_faces: Vec::new(),
            adjust: None,
        }
    }

    with! {
        /// With slaves that were adjusted, or without.
        with_adjust(adjust: Option<f64>);
        /// With augmentation, or without.
        with_augmentation(augmentation: Option<Augmentation>);
        /// With this rule of pairing anew.
        with_refresh(refresh: RefreshRule);
        /// With this tangent.
        with_tangent(tangent: TangentRule);
        /// Paired the other way round, too, or not.
        with_two_pass(two_pass: bool);
        /// With one surface in contact with itself, or with two.
        with_self_contact(self_contact: bool);
        /// With this element and pairing.
        with_interface(interface: InterfaceOptions);
        /// With these planes of symmetry.
        with_symmetry(symmetry: Vec<SymmetryPlane>);
        /// With friction, or without.
        with_friction(friction: Option<Friction>);
        /// Integrated over nodes or faces.
        with_integration(integration: Integration);
        /// With faces of second order.
        with_quadratic_faces(quadratic_faces: Vec<QuadraticFace>);
    }
}
