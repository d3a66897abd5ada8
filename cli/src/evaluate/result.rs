//! What `evaluate` answers for one element.

use diffuse_contact::friction::{Coulomb, FrictionError, NormalForce};
use diffuse_contact::neighbourhood::element_regularity;
use diffuse_contact::{
    Backend, Domains, Element, ElementError, Frame, FrameDerivative, MaterialDomain, MaterialPlace, Mode,
    Point, Slip, pairing,
};
use serde::Serialize;

use super::schema::{ElementInput, FrameInput, FrictionInput, Metric};
use crate::contact_options::frame_name;
use crate::json::{Coordinates, FrameOutput};
use crate::outcome::Outcome;

/// The contact quantities of one element, in global axes; vectors and matrices over the 3(n+1) coordinates ordered
/// slave, master 1, …, master n. Equation numbers are those of Chamoret et al. 2008.
#[derive(Debug, Serialize)]
pub struct Evaluated {
    /// Whether the slave penetrates, g < 0. `force` and `tangent` are (33) and (43) for either sign of g; a
    /// caller whose contact cannot pull adds them only when this is true.
    active: bool,
    /// Signed gap g (19): positive apart, negative penetrating.
    gap: f64,
    /// Foot point on the smooth surface.
    foot: Point,
    /// Unit normal of the smooth surface at the foot (22), outward.
    normal: Point,
    /// Coefficients of the fit about the slave, in the axes of `frame`, in length units.
    coefficients: Vec<f64>,
    /// The frame that was used.
    frame: FrameOutput,
    /// What it did while the gap was differentiated.
    frame_derivative: &'static str,
    /// The support radius that was used; with domains in the first configuration the distance of the farthest master within reach.
    support_radius: f64,
    /// The slave's place in the first configuration, if the element has domains there.
    place: Option<Point>,
    /// How well the masters carry the fit, from 0 to 1, as `neighbours` measures it: near 0 the entries of N and M may be large.
    regularity: Option<f64>,
    /// N = ∂g/∂x (32).
    n: Vec<f64>,
    /// M = ∂²g/∂x∂x (42), full rows.
    m: Vec<Vec<f64>>,
    /// R = −ε g N (33).
    force: Vec<f64>,
    /// K = −∂R/∂x = ε (g M + N Nᵀ) (43), full rows.
    tangent: Vec<Vec<f64>>,
    /// The slip from the anchor, if the element has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    slip: Option<SlipOutput>,
    /// The friction, if it was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    friction: Option<FrictionOutput>,
}

/// The slip from the anchor; vectors and matrices over the 3(n+2) coordinates ordered slave, master 1, …, master n, anchor.
#[derive(Debug, Serialize)]
struct SlipOutput {
    /// q = ½ |P_ν d|² (docs/equations.md, T16): half the square of the slip.
    q: f64,
    /// ∇q = ∂q/∂x.
    gradient: Vec<f64>,
    /// ∇²q = ∂²q/∂x∂x, full rows.
    hessian: Vec<Vec<f64>>,
    /// The masters' weights in the foot: x^d = Σ φ_k x^k (T15).
    foot_weights: Vec<f64>,
}

/// Friction by Coulomb's law, over the same coordinates. It comes on top of `force` and `tangent`, which are those of the
/// penalty alone.
#[derive(Debug, Serialize)]
struct FrictionOutput {
    /// `open`, `stick` or `slip`.
    state: &'static str,
    /// The force R = −c ∇q.
    force: Vec<f64>,
    /// K = −∂R/∂x, full rows; in slip not symmetric.
    tangent: Vec<Vec<f64>>,
}

/// Most masters of an element: its two matrices have nine times the square of their number as entries, each about twenty characters of
/// the output.
const MOST_MASTERS: usize = 1_000;
/// Entries of a metric across its diagonal differ by no more than this part of its largest entry.
const ASYMMETRY: f64 = 1e-12;
/// Numbers held at once for each entry of such a matrix: both matrices as rows and packed, and what they are computed from.
const NUMBERS_OF_ENTRY: usize = 4;

/// Why an element that follows the schema has no result.
#[derive(Debug, thiserror::Error)]
enum Refusal {
    #[error(transparent)]
    Element(#[from] ElementError),
    /// The average plane has two sides and nothing tells them apart.
    #[error("`outward` is missing: it tells which side of the average plane is outside")]
    MissingOutward,
    #[error(
        "`frame_derivative` cannot be \"co-moving\" with a given frame, which does not move with the nodes: leave it \
         out or take \"held\", or leave out `frame` for the average plane"
    )]
    CoMovingGivenFrame,
    #[error(
        "`{missing}` is missing: domains in the first configuration need `first_positions` and `metrics`, one for each master"
    )]
    IncompleteDomains { missing: &'static str },
    #[error(
        "`{field}` cannot be given with `first_positions`: the metrics say how far the domains reach; leave out one of them"
    )]
    RadiusWithDomains { field: &'static str },
    #[error("`{field}` has {found} entries for {expected} masters")]
    WrongNumberOfDomains { field: &'static str, found: usize, expected: usize },
    /// The search for the place failed: too few domains hold it.
    #[error("the slave has no place in the first configuration among these domains: {0}")]
    NoPlace(ElementError),
    #[error("`metrics[{index}]` is no ellipsoid: the matrix has to be {property}")]
    InvalidMetric { index: usize, property: &'static str },
    #[error(
        "an element can have {MOST_MASTERS} masters at most, not {found}: its matrices have the square of their number; take those around \
         the slave, which `neighbours` finds"
    )]
    TooManyMasters { found: usize },
    #[error("there is no memory for the matrices of {masters} masters, about {megabytes} MB")]
    NoMemory { masters: usize, megabytes: usize },
    #[error(
        "`anchor` is missing: friction acts against the slip from an anchor; the foot of first touch is one"
    )]
    FrictionWithoutAnchor,
    #[error(transparent)]
    Friction(#[from] FrictionError),
    #[error("the penalty must be positive, not {value}")]
    InvalidPenalty { value: f64 },
}

impl Refusal {
    const fn code(&self) -> &'static str {
        match self {
            Self::Element(error) => error.code(),
            Self::TooManyMasters { .. } => "too-many-masters",
            Self::NoMemory { .. } => "no-memory",
            Self::IncompleteDomains { .. } => "incomplete-domains",
            Self::RadiusWithDomains { .. } => "radius-with-domains",
            Self::WrongNumberOfDomains { .. } => "wrong-number-of-domains",
            Self::NoPlace(_) => "not-material-place",
            Self::InvalidMetric { .. } => "invalid-metric",
            Self::MissingOutward => "missing-outward",
            Self::CoMovingGivenFrame => "co-moving-given-frame",
            Self::FrictionWithoutAnchor => "missing-anchor",
            Self::Friction(error) => error.code(),
            Self::InvalidPenalty { .. } => "invalid-penalty",
        }
    }
}

/// Evaluates one element with all derivatives.
pub fn evaluate(input: &ElementInput, backend: &dyn Backend) -> Outcome<Evaluated> {
    match evaluated(input, backend) {
        Ok(evaluated) => Outcome::Ok(Box::new(evaluated)),
        Err(refusal) => Outcome::Error { code: refusal.code(), message: refusal.to_string() },
    }
}

fn evaluated(input: &ElementInput, backend: &dyn Backend) -> Result<Evaluated, Refusal> {
    if !(input.penalty.is_finite() && input.penalty > 0.0) {
        return Err(Refusal::InvalidPenalty { value: input.penalty });
    }
    let masters = input.masters();
    let basis = input.basis();
    if masters.len() < basis.size() {
        return Err(ElementError::TooFewNodes { found: masters.len(), needed: basis.size() }.into());
    }
    check_memory(masters.len())?;
    if input.friction.is_some() && input.anchor.is_none() {
        return Err(Refusal::FrictionWithoutAnchor);
    }
    if let Some(domains) = domains(input)? {
        return with_domains(input, backend, &masters, &domains);
    }
    let frame = frame(input, &masters)?;
    let slave = input.slave.0;
    let default = || match &input.support_radii {
        Some(radii) => radii.iter().copied().fold(0.0, f64::max),
        None => pairing::support_radius(&frame, slave, &masters),
    };
    let support_radius = input.support_radius.unwrap_or_else(default);
    let element = Element::new(slave, &masters, frame, support_radius)
        .with_domains(input.support_radii.as_deref().map_or(Domains::Shared, Domains::Each))
        .with_basis(basis)
        .with_weight(input.weight);
    element.validate()?;
    answer(&element, None, input, backend)
}

/// Domains of influence in the first configuration, if the element has any.
fn domains(input: &ElementInput) -> Result<Option<Vec<MaterialDomain>>, Refusal> {
    let (positions, metrics) = match (&input.first_positions, &input.metrics) {
        (None, None) => return Ok(None),
        (Some(positions), Some(metrics)) => (positions, metrics),
        (None, _) => return Err(Refusal::IncompleteDomains { missing: "first_positions" }),
        (_, None) => return Err(Refusal::IncompleteDomains { missing: "metrics" }),
    };
    let given = [
        ("support_radius", input.support_radius.is_some()),
        ("support_radii", input.support_radii.is_some()),
    ];
    if let Some((field, _)) = given.into_iter().find(|(_, is_given)| *is_given) {
        return Err(Refusal::RadiusWithDomains { field });
    }
    let expected = input.masters.len();
    for (field, found) in [("first_positions", positions.len()), ("metrics", metrics.len())] {
        if found != expected {
            return Err(Refusal::WrongNumberOfDomains { field, found, expected });
        }
    }
    let domain = |(index, (&Coordinates(position), &Metric(rows)))| {
        let refused = |property| Refusal::InvalidMetric { index, property };
        let size = rows.as_flattened().iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        let is_symmetric = |(i, j): (usize, usize)| (rows[i][j] - rows[j][i]).abs() <= ASYMMETRY * size;
        if ![(0, 1), (0, 2), (1, 2)].into_iter().all(is_symmetric) {
            return Err(refused("symmetric"));
        }
        MaterialDomain::of_ellipsoid(position, rows).ok_or(refused("positive definite"))
    };
    positions.iter().zip(metrics).enumerate().map(domain).collect::<Result<_, _>>().map(Some)
}

/// The element of an interface: the place in the first configuration, then the plane weighted there.
fn with_domains(
    input: &ElementInput,
    backend: &dyn Backend,
    masters: &[Point],
    domains: &[MaterialDomain],
) -> Result<Evaluated, Refusal> {
    if input.frame != FrameInput::AveragePlane || input.frame_derivative() == FrameDerivative::Held {
        return Err(ElementError::HeldFrame.into());
    }
    let Coordinates(outward) = input.outward.ok_or(Refusal::MissingOutward)?;
    let (slave, basis) = (input.slave.0, input.basis());
    let found = MaterialPlace::find(slave, masters, domains, |r| input.weight.fitting(r), outward);
    let found = found.map_err(|error| match error {
        ElementError::NotMaterialPlace { .. } | ElementError::NoAveragePlane { .. } => {
            Refusal::NoPlace(error)
        }
        other => other.into(),
    })?;
    let nodes = found.nodes(domains);
    let distance = |x: &Point| slave.iter().zip(x).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    let within_reach = masters.iter().zip(&nodes).filter(|(_, node)| node.distance() < 1.0);
    let distances: Vec<f64> = within_reach.map(|(master, _)| distance(master)).collect();
    if distances.len() < basis.size() {
        return Err(ElementError::TooFewNodes { found: distances.len(), needed: basis.size() }.into());
    }
    let farthest = distances.into_iter().fold(0.0, f64::max);
    let element = Element::new(slave, masters, found.frame, farthest)
        .with_domains(Domains::Material(&nodes))
        .with_basis(basis)
        .with_weight(input.weight);
    element.validate()?;
    answer(&element, Some(found.place), input, backend)
}

/// One element that is too large is no end of the others. A failed allocation would be.
fn check_memory(masters: usize) -> Result<(), Refusal> {
    if masters > MOST_MASTERS {
        return Err(Refusal::TooManyMasters { found: masters });
    }
    let numbers = NUMBERS_OF_ENTRY * (3 * (masters + 1)).pow(2);
    // Memory that is asked for and not touched costs nothing.
    Vec::<f64>::new()
        .try_reserve_exact(numbers)
        .map_err(|_| Refusal::NoMemory { masters, megabytes: numbers * size_of::<f64>() / 1_000_000 })
}

fn frame(input: &ElementInput, masters: &[Point]) -> Result<Frame, Refusal> {
    let outward = input.outward.map(|Coordinates(outward)| outward);
    match (&input.frame, input.frame_derivative()) {
        (FrameInput::AveragePlane, derivative) => {
            let outward = outward.ok_or(Refusal::MissingOutward)?;
            let plane = match &input.support_radii {
                Some(radii) => {
                    let weight = |r| input.weight.fitting(r);
                    Frame::moving_plane(input.slave.0, masters, radii, weight, 1.0, outward)?
                }
                None => Frame::average_plane(masters, outward)?,
            };
            Ok(Frame { derivative, ..plane })
        }
        (FrameInput::Given(given), FrameDerivative::Held) => {
            Ok(Frame::given(given.origin.0, given.t1.0, given.t2.0, given.normal.0, outward)?)
        }
        (FrameInput::Given(_), FrameDerivative::CoMoving) => Err(Refusal::CoMovingGivenFrame),
    }
}

/// The entry of the output. JSON knows no infinity, so a product that overflows is an error.
fn answer(
    element: &Element<'_>,
    place: Option<Point>,
    input: &ElementInput,
    backend: &dyn Backend,
) -> Result<Evaluated, Refusal> {
    let slip =
        input.anchor.map(|Coordinates(anchor)| backend.slip(element, anchor, Mode::Hessian)).transpose()?;
    // The same bits with and without an anchor.
    let gap = backend.gap(element, Mode::Hessian)?;
    let force = gap.contact_force(input.penalty);
    let tangent = gap.tangent(input.penalty);
    finite("force", &force)?;
    finite("tangent", tangent.packed())?;
    finite("gap gradient", &gap.gradient)?;
    finite("gap Hessian", gap.hessian.packed())?;
    finite("coefficient", &gap.coefficients)?;
    let sliding = slip.as_ref().zip(input.friction);
    let friction = sliding.map(|(slip, law)| friction(slip, law, input.penalty)).transpose()?;
    Ok(Evaluated {
        active: gap.is_penetrating(),
        gap: gap.gap,
        foot: gap.foot,
        normal: gap.normal,
        coefficients: gap.coefficients,
        frame: element.frame.into(),
        frame_derivative: frame_name(element.frame.derivative),
        support_radius: element.support_radius,
        place,
        regularity: element_regularity(element),
        n: gap.gradient,
        m: gap.hessian.to_rows(),
        force,
        tangent: tangent.to_rows(),
        slip: slip.map(slip_output).transpose()?,
        friction,
    })
}

fn slip_output(slip: Slip) -> Result<SlipOutput, ElementError> {
    finite("slip", &[slip.half_square])?;
    finite("slip gradient", &slip.gradient)?;
    finite("slip Hessian", slip.hessian.packed())?;
    finite("foot weight", &slip.foot_weights)?;
    let Slip { half_square: q, gradient, hessian, foot_weights, .. } = slip;
    Ok(SlipOutput { q, gradient, hessian: hessian.to_rows(), foot_weights })
}

/// Friction under the penalty's force p = ⟨−ε g⟩.
fn friction(slip: &Slip, law: FrictionInput, penalty: f64) -> Result<FrictionOutput, Refusal> {
    let normal = NormalForce { force: (-penalty * slip.contact.gap).max(0.0), stiffness: penalty };
    let coulomb = Coulomb::new(law.coefficient, law.stiffness)?.with_shear_limit(law.shear_limit)?;
    let force = coulomb.force(normal, slip.half_square);
    force.check()?;
    let (nodal, tangent) = (force.contact_force(slip), force.tangent(slip));
    finite("friction force", &nodal)?;
    tangent.iter().try_for_each(|row| finite("friction tangent", row))?;
    Ok(FrictionOutput { state: force.state.name(), force: nodal, tangent })
}

fn finite(what: &'static str, numbers: &[f64]) -> Result<(), ElementError> {
    if numbers.iter().all(|x| x.is_finite()) { Ok(()) } else { Err(ElementError::Overflow { what }) }
}
