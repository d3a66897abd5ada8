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
#[allow(missing_docs)] // The messages say what the fields are.
pub enum ContactError {
    #[error("interface `{interface}`, master surface: {source}", interface = shown(interface))]
    Master { interface: String, source: SurfaceError },
    /// The interface refused its slaves, options or positions.
    #[error("interface `{interface}`: {source}", interface = shown(interface))]
    Interface { interface: String, source: InterfaceError },
    /// Forces or stiffnesses could not be summed.
    #[error("interface `{interface}`: {source}", interface = shown(interface))]
    Assembly { interface: String, source: AssemblyError },
    /// The coefficient of friction or its stiffness is none.
    #[error("interface `{interface}`: {source}", interface = shown(interface))]
    Friction { interface: String, source: FrictionError },
    /// Multipliers belong to one pass, and so does a law of friction that looks at pressures.
    #[error(
        "interface `{interface}`: multipliers split the pressure between two passes in no certain way, so that a shear limit, or a \
         coefficient by pressure, needs one pass or the penalty alone",
        interface = shown(interface)
    )]
    SplitPressure { interface: String },
    #[error("interface `{interface}`: the penalty is {value:e}; it has to be positive and finite", interface = shown(interface))]
    Penalty { interface: String, value: f64 },
    #[error(
        "interface `{interface}`: the tangent is an operator only of contact over nodes, with friction as it is",
        interface = shown(interface)
    )]
    NoOperator { interface: String },
    /// History of another problem; `what` is `"multipliers"`, `"histories of friction"` or `"loaded slaves"`.
    #[error("there are {what} for {found} passes or slaves; this problem has {expected}")]
    OtherPasses { what: &'static str, found: usize, expected: usize },
}
