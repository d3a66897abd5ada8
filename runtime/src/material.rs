//! The slave's place in the master's first configuration, where domains of influence stay what they are
//! (`docs/equations.md`, \[T18\]).

mod broyden;
mod equations;
mod search;

pub(crate) use search::{SearchScratch, Sought, places};

use crate::vector::Vector3;
use crate::{ElementError, Frame, MaterialNode, Point};
use search::Function;

/// A pivot of an ellipsoid's matrix below this part of its diagonal is rounding.
const SINGULAR: f64 = 1e-14;
/// Largest step that a given place may be off its equations, as a fraction of the domain of the node nearest to the slave.
const PLACE_TOLERANCE: f64 = 1e-6;

/// The domain of influence of a master node: an ellipsoid around its first position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialDomain {
    /// First position X_k of the node.
    pub position: Point,
    /// Upper triangle U of the metric, rows xx, xy, xz, yy, yz, zz, 1/length: the domain is where |U (X − X_k)| < 1.
    pub metric: [f64; 6],
}

/// The place Ξ in the first configuration that the slave has now, and the average plane of the nodes as they are weighted there.
///
/// Ξ is the affine fit of the nodes' first positions by their positions in the plane, taken at the slave, with the weights
/// ω(|U_k (X_k − Ξ)|).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaterialPlace {
    /// Ξ
    pub place: Point,
    /// The plane, which moves with the nodes.
    pub frame: Frame,
    /// How often its equations were evaluated.
    pub steps: usize,
}

impl MaterialPlace {
    /// The place of a slave over these masters. The iteration starts at the first position of the master nearest to the slave. An interface
    /// takes the same steps, for many slaves side by side.
    ///
    /// `fitting_weight`: ω, see [`Weight::fitting`](crate::Weight::fitting). `outward`: towards the side of the slave.
    ///
    /// # Errors
    /// [`ElementError::WrongNumberOfDomains`], [`ElementError::NonFiniteInput`], [`ElementError::TooFewNodes`]; as
    /// [`Frame::average_plane`] for the nodes within reach; [`ElementError::NotMaterialPlace`] if the iteration does not converge.
    pub fn find(
        slave: Point,
        masters: &[Point],
        domains: &[MaterialDomain],
        fitting_weight: impl Fn(f64) -> f64,
        outward: Point,
    ) -> Result<Self, ElementError> {
        if domains.len() != masters.len() {
            return Err(ElementError::WrongNumberOfDomains { found: domains.len(), expected: masters.len() });
        }
        let is_finite = |x: &[f64]| x.iter().all(|x| x.is_finite());
        let bad = |(x, domain): (&Point, &MaterialDomain)| {
            !(is_finite(x) && is_finite(&domain.position) && is_finite(&domain.metric))
        };
        if let Some(index) = masters.iter().zip(domains).position(bad) {
            return Err(ElementError::NonFiniteInput { what: "master", index });
        }
        let sought = Sought { slave, outward, range: 0..masters.len() };
        search::place(&sought, (masters, domains), &Function(fitting_weight), &mut Vec::new())
    }

    /// The masters as an element takes them.
    pub fn nodes(&self, domains: &[MaterialDomain]) -> Vec<MaterialNode> {
        domains.iter().map(|domain| domain.from(self.place)).collect()
    }
}

impl MaterialDomain {
    /// The domain of all X with (X − X_k)ᵀ C⁻¹ (X − X_k) < 1: the eigenvalues of C are the squares of its half axes, along the
    /// eigenvectors. Of C the upper triangle is read. `None` if C is not positive definite to rounding.
    ///
    /// ```
    /// use diffuse_contact::MaterialDomain;
    ///
    /// // Half axes 2, 1 and 0.5.
    /// let squares = [[4.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.25]];
    /// let domain = MaterialDomain::of_ellipsoid([1.0, 0.0, 0.0], squares).unwrap();
    /// assert_eq!(domain.from([3.0, 0.0, 0.0]).distance(), 1.0);
    /// assert_eq!(domain.ellipsoid(), squares);
    /// ```
    pub fn of_ellipsoid(position: Point, squares: [[f64; 3]; 3]) -> Option<Self> {
        let [[c_xx, c_xy, c_xz], [_, c_yy, c_yz], [_, _, c_zz]] = squares;
        let root = |square: f64, whole: f64| {
            (square > SINGULAR * whole && square.is_finite()).then(|| square.sqrt())
        };
        // C = R Rᵀ with R an upper triangle; U = R⁻¹.
        let zz = root(c_zz, 0.0)?;
        let (yz, xz) = (c_yz / zz, c_xz / zz);
        let yy = root(c_yy - yz * yz, c_yy)?;
        let xy = (c_xy - xz * yz) / yy;
        let xx = root(c_xx - xy * xy - xz * xz, c_xx)?;
        let [u_xx, u_yy, u_zz] = [xx, yy, zz].map(f64::recip);
        let u_yz = -yz * u_zz * u_yy;
        let metric = [u_xx, -xy * u_yy * u_xx, -(xy * u_yz + xz * u_zz) * u_xx, u_yy, u_yz, u_zz];
        metric.iter().all(|x| x.is_finite()).then_some(Self { position, metric })
    }

    /// C of [`of_ellipsoid`](Self::of_ellipsoid).
    pub fn ellipsoid(&self) -> [[f64; 3]; 3] {
        let [u_xx, u_xy, u_xz, u_yy, u_yz, u_zz] = self.metric;
        let [xx, yy, zz] = [u_xx, u_yy, u_zz].map(f64::recip);
        let yz = -u_yz * zz * yy;
        let rows = [[xx, -u_xy * yy * xx, -(u_xy * yz + u_xz * zz) * xx], [0.0, yy, yz], [0.0, 0.0, zz]];
        rows.map(|row| rows.map(|other| Vector3::from(row).dot(&Vector3::from(other))))
    }

    /// The node seen from a place.
    pub fn from(&self, place: Point) -> MaterialNode {
        let offset = [0, 1, 2].map(|k| self.position[k] - place[k]);
        MaterialNode { offset, metric: self.metric }
    }
}

/// Checks that the place that nodes are seen from is a root of its equations in this frame.
pub(crate) fn check_place(
    slave: Point,
    masters: &[Point],
    nodes: &[MaterialNode],
    frame: &Frame,
    fitting_weight: impl Fn(f64) -> f64,
) -> Result<(), ElementError> {
    let domains: Vec<MaterialDomain> =
        nodes.iter().map(|node| MaterialDomain { position: node.offset, metric: node.metric }).collect();
    let sought = Sought { slave, outward: frame.normal, range: 0..masters.len() };
    let deviation = search::deviation(&sought, (masters, &domains), frame.normal, &Function(fitting_weight));
    if deviation <= PLACE_TOLERANCE { Ok(()) } else { Err(ElementError::NotMaterialPlace { deviation }) }
}
