//! Named numbers. C passes them as `int32_t`: a number without name is refused, it is no undefined behaviour.

use runtime::assembly::{Tangent, Triangle};
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
    /// Directions given by the caller, held (dc_gap only).
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
#[derive(Clone, Copy, Debug)]
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

/// Which triangle of a symmetric matrix is listed.
#[repr(C)]
pub enum dc_triangle {
    /// Both.
    DC_FULL = 0,
    /// Entries with row >= column.
    DC_LOWER = 1,
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

#[inline]
pub fn mode(value: i32) -> Result<Mode, Failure> {
    let choices = [
        (dc_mode::DC_VALUE as i32, Mode::Value),
        (dc_mode::DC_GRADIENT as i32, Mode::Gradient),
        (dc_mode::DC_HESSIAN as i32, Mode::Hessian),
    ];
    choose("mode", value, &choices)
}

#[inline]
pub fn weight(value: i32) -> Result<Weight, Failure> {
    let choices = [
        (dc_weight::DC_CUBIC as i32, Weight::Cubic),
        (dc_weight::DC_CUBIC_INTERPOLATING as i32, Weight::CubicInterpolating),
        (dc_weight::DC_WENDLAND_C2 as i32, Weight::WendlandC2),
    ];
    choose("weight", value, &choices)
}

pub fn weight_number(weight: Weight) -> i32 {
    (match weight {
        Weight::Cubic => dc_weight::DC_CUBIC,
        Weight::CubicInterpolating => dc_weight::DC_CUBIC_INTERPOLATING,
        Weight::WendlandC2 => dc_weight::DC_WENDLAND_C2,
    }) as i32
}

/// What the frame of an interface does.
#[inline]
pub fn frame(value: i32) -> Result<FrameDerivative, Failure> {
    let choices = [
        (dc_frame::DC_CO_MOVING as i32, FrameDerivative::CoMoving),
        (dc_frame::DC_HELD as i32, FrameDerivative::Frozen),
    ];
    choose("frame", value, &choices)
}

/// What the frame of a single element does that is not given.
#[inline]
pub fn element_frame(value: i32) -> Result<FrameDerivative, Failure> {
    if value == dc_frame::DC_CO_MOVING as i32 || value == dc_frame::DC_HELD as i32 {
        return frame(value);
    }
    let message = format!("invalid-option: frame is {value}, which is none of 0, 1, 2");
    Err(Failure::new(DC_BAD_OPTION, message))
}

#[inline]
pub fn basis(value: i32) -> Result<Basis, Failure> {
    let choices =
        [(dc_basis::DC_LINEAR as i32, Basis::Linear), (dc_basis::DC_QUADRATIC as i32, Basis::Quadratic)];
    choose("basis", value, &choices)
}

pub fn basis_number(basis: Basis) -> i32 {
    (if basis == Basis::Linear { dc_basis::DC_LINEAR } else { dc_basis::DC_QUADRATIC }) as i32
}

pub fn coefficient(value: i32) -> Result<dc_coefficient, Failure> {
    use dc_coefficient::{DC_CONSTANT, DC_DECAYING, DC_FUNCTION, DC_TABULATED};
    let all = [DC_CONSTANT, DC_DECAYING, DC_TABULATED, DC_FUNCTION];
    choose("coefficient", value, &all.map(|kind| (kind as i32, kind)))
}

pub fn tangent(value: i32) -> Result<Tangent, Failure> {
    let choices = [
        (dc_tangent::DC_EXACT as i32, Tangent::Exact),
        (dc_tangent::DC_GAUSS_NEWTON as i32, Tangent::GaussNewton),
    ];
    choose("tangent", value, &choices)
}

pub fn tangent_number(tangent: Tangent) -> i32 {
    (match tangent {
        Tangent::Exact => dc_tangent::DC_EXACT,
        Tangent::GaussNewton => dc_tangent::DC_GAUSS_NEWTON,
    }) as i32
}

pub fn friction_state(state: FrictionState) -> i32 {
    (match state {
        FrictionState::Open => dc_friction_state::DC_OPEN,
        FrictionState::Stick => dc_friction_state::DC_STICK,
        FrictionState::Slip => dc_friction_state::DC_SLIP,
    }) as i32
}

pub fn triangle(value: i32) -> Result<Triangle, Failure> {
    let choices =
        [(dc_triangle::DC_FULL as i32, Triangle::Full), (dc_triangle::DC_LOWER as i32, Triangle::Lower)];
    choose("triangle", value, &choices)
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
