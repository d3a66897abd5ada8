//! What the contact part of the solver can refuse.

use diffuse_contact::assembly::AssemblyError;
use diffuse_contact::friction::FrictionError;
use diffuse_contact::interface::InterfaceError;
use diffuse_contact::surface::SurfaceError;
use diffuse_contact_mesh::names::shown;
use thiserror::Error;

/// Why contact could not be set up or evaluated.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ContactError {
    /// The master facets are no surface.
    #[error("interface `{interface}`, master surface: {source}", interface = shown(interface))]
    Master {
        /// Its name.
        interface: String,
        /// The reason.
        source: SurfaceError,
    },
    /// The interface refused its slaves, options or positions.
    #[error("interface `{interface}`: {source}", interface = shown(interface))]
    Interface {
        /// Its name.
        interface: String,
        /// The reason.
        source: InterfaceError,
    },
    /// Forces or stiffnesses could not be summed.
    #[error("interface `{interface}`: {source}", interface = shown(interface))]
    Assembly {
        /// Its name.
        interface: String,
        /// The reason.
        source: AssemblyError,
    },
    /// The coefficient of friction or its stiffness is none.
    #[error("interface `{interface}`: {source}", interface = shown(interface))]
    Friction {
        /// Its name.
        interface: String,
        /// The reason.
        source: FrictionError,
    },
    /// The penalty is not a positive number.
    #[error("interface `{interface}`: the penalty is {value:e}; it has to be positive and finite", interface = shown(interface))]
    Penalty {
        /// Its name.
        interface: String,
        /// What was given.
        value: f64,
    },
    /// The tangent of such contact is no operator.
    #[error(
        "interface `{interface}`: the tangent is an operator only of contact over nodes, with friction as it is",
        interface = shown(interface)
    )]
    NoOperator {
        /// Its name.
        interface: String,
    },
    /// History of another problem.
    #[error("there are {what} for {found} passes or slaves; this problem has {expected}")]
    OtherPasses {
        /// `"multipliers"`, `"histories of friction"` or `"loaded slaves"`.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many belong here.
        expected: usize,
    },
}
