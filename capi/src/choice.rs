//! Named numbers. C passes them as `int32_t`: a number without name is refused, it is no undefined behaviour.

use runtime::assembly::{Tangent, Triangle};
use runtime::faces::FacePressures;
use runtime::{Basis, FrameDerivative, FrictionState, Mode, Weight};

use crate::status::{DC_BAD_OPTION, Failure};

/// How many derivatives are computed.
#[repr(C)]
pub enum dc_mode {
    /// Gap, foot and normal.
    DC_VALUE = 0,
    /// With the gradient N of the gap.
    DC_GRADIENT = 1,
    /// With the Hessian M of the gap, too.
    DC_HESSIAN = 2,
}

/// The element of every slave node.
#[repr(C)]
pub enum dc_element_kind {
    /// The diffuse element: a smooth surface through the master nodes around the slave.
    DC_DIFFUSE = 0,
    /// The classic element: the distance from the closest facet.
    DC_NODE_TO_FACET = 1,
}

/// Weight function of the fit, r = distance from the slave over the support radius.
#[repr(C)]
pub enum dc_weight {
    /// 1 - 3 r^2 + 2 r^3.
    DC_CUBIC = 0,
    /// w/(1 - w) of the cubic weight w: the surface passes through the master nodes.
    DC_CUBIC_INTERPOLATING = 1,
    /// (1 - r)^4 (1 + 4 r): the Hessian does not jump where a node leaves the support.
    DC_WENDLAND_C2 = 2,
}

/// The frame of the fit.
#[repr(C)]
pub enum dc_frame {
    /// The average plane of the masters, moving with them: N and M are the exact derivatives of the gap.
    DC_CO_MOVING = 0,
    /// The average plane of the masters, held while differentiating. An interface holds that of the last refresh; with DC_DOMAINS, where
    /// the plane is one with the slave's place, it is refused.
    DC_HELD = 1,
    /// Directions given by the caller, held: dc_gap, and dc_gap_batch with one frame for all elements.
    DC_GIVEN = 2,
}

/// Which master nodes take part.
#[repr(C)]
pub enum dc_rule {
    /// Those of the first layers of convex hulls around the slave.
    DC_HULL_LAYERS = 0,
    /// All within the radius that the layers set.
    DC_HULL_RADIUS = 1,
    /// The nearest.
    DC_NEAREST = 2,
    /// All nodes of the slave's sheet within whose domain of influence it lies, and their mirror images: a node enters and leaves with
    /// weight zero, so the gap does not jump. Domains are ellipsoids around the positions of dc_create; the slave has a place there.
    /// Only interfaces have the rule: domains belong to the nodes of a surface.
    DC_DOMAINS = 3,
}

/// Polynomial basis of the fit.
#[repr(C)]
pub enum dc_basis {
    /// 1, a, b: at least 3 masters.
    DC_LINEAR = 1,
    /// 1, a, b, a^2, a b, b^2: at least 6 masters.
    DC_QUADRATIC = 2,
}

/// What a contact with friction does.
#[repr(C)]
pub enum dc_friction_state {
    /// There is no pressure, or no friction.
    DC_OPEN = 0,
    /// The traction is below friction x pressure.
    DC_STICK = 1,
    /// The traction is friction x pressure, against the slip.
    DC_SLIP = 2,
}

/// The coefficient of Coulomb's friction.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum dc_coefficient {
    /// A number.
    DC_CONSTANT = 0,
    /// mu = mu_k + (mu_s - mu_k) exp(-decay x slip rate), from rest to fast sliding.
    DC_DECAYING = 1,
    /// A table of pressures and slip rates.
    DC_TABULATED = 2,
    /// A function of the caller's.
    DC_FUNCTION = 3,
}

/// Which tangent is assembled.
#[repr(C)]
pub enum dc_tangent {
    /// K = e N N^T - f M, the exact derivative of the force; indefinite in general. See dc_adaptive_tangent.
    DC_EXACT = 0,
    /// K = e N N^T, positive semidefinite; needs no Hessian.
    DC_GAUSS_NEWTON = 1,
}

/// Where pressures of contact over faces follow from gaps.
#[repr(C)]
pub enum dc_face_pressures {
    /// At the slave's nodes, from the average gap around each.
    DC_NODE_PRESSURES = 0,
    /// At each integration point, from its own gap.
    DC_POINT_PRESSURES = 1,
}

/// Which triangle of a symmetric matrix is listed.
#[repr(C)]
pub enum dc_triangle {
    /// Both.
    DC_FULL = 0,
    /// Entries with row >= column.
    DC_LOWER = 1,
}

/// A type of Rust whose values have numbers in C.
pub trait Named: Copy + 'static {
    /// What messages call it.
    const NAME: &'static str;
    /// Its values and their numbers.
    const ALL: &'static [(i32, Self)];

    /// The number of the value.
    fn number(self) -> i32;
}

/// The values of a type and their names in C, and the number of others; a value without a number does not compile.
macro_rules! named {
    ($name:literal, $type:ty, $names:ty: $($value:ident = $number:ident),+ $(; $others:pat = $other:ident)?) => {
        impl Named for $type {
            const NAME: &'static str = $name;
            const ALL: &'static [(i32, Self)] = &[$((<$names>::$number as i32, Self::$value)),+];

            fn number(self) -> i32 {
                match self {
                    $(Self::$value => <$names>::$number as i32,)+
                    $($others => <$names>::$other as i32,)?
                }
            }
        }
    };
}

named!("mode", Mode, dc_mode: Value = DC_VALUE, Gradient = DC_GRADIENT, Hessian = DC_HESSIAN);
named!("weight", Weight, dc_weight: Cubic = DC_CUBIC, CubicInterpolating = DC_CUBIC_INTERPOLATING, WendlandC2 = DC_WENDLAND_C2);
named!("frame", FrameDerivative, dc_frame: CoMoving = DC_CO_MOVING, Held = DC_HELD);
named!("basis", Basis, dc_basis: Linear = DC_LINEAR, Quadratic = DC_QUADRATIC; Self::Custom(_) = DC_QUADRATIC);
named!("friction state", FrictionState, dc_friction_state: Open = DC_OPEN, Stick = DC_STICK, Slip = DC_SLIP);
named!("coefficient", dc_coefficient, dc_coefficient:
    DC_CONSTANT = DC_CONSTANT, DC_DECAYING = DC_DECAYING, DC_TABULATED = DC_TABULATED, DC_FUNCTION = DC_FUNCTION);
named!("tangent", Tangent, dc_tangent: Exact = DC_EXACT, GaussNewton = DC_GAUSS_NEWTON);
named!("pressures", FacePressures, dc_face_pressures: Nodes = DC_NODE_PRESSURES, Points = DC_POINT_PRESSURES);
named!("triangle", Triangle, dc_triangle: Full = DC_FULL, Lower = DC_LOWER);

/// The value of a number.
#[inline]
pub fn read<T: Named>(number: i32) -> Result<T, Failure> {
    choose(T::NAME, number, T::ALL)
}

/// The entry of `choices` that has this number.
#[inline]
pub fn choose<T: Copy>(name: &str, value: i32, choices: &[(i32, T)]) -> Result<T, Failure> {
    let found = choices.iter().find(|(number, _)| *number == value);
    found.map(|(_, choice)| *choice).ok_or_else(|| {
        let numbers: Vec<String> = choices.iter().map(|(number, _)| number.to_string()).collect();
        let message = format!("invalid-option: {name} is {value}, which is none of {}", numbers.join(", "));
        Failure::new(DC_BAD_OPTION, message)
    })
}

/// A flag: 0 or 1.
pub fn flag(name: &str, value: i32) -> Result<bool, Failure> {
    choose(name, value, &[(0, false), (1, true)])
}

/// A count or an index that C has as `int32_t`.
pub fn count(name: &'static str, value: i32) -> Result<usize, Failure> {
    usize::try_from(value).map_err(|_| {
        Failure::new(DC_BAD_OPTION, format!("invalid-option: {name} is {value}, but must not be negative"))
    })
}
