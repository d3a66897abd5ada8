//! One contact element: a slave node, its master nodes, and the data held fixed between updates.

use crate::material::check_place;
use crate::vector::Vector3;
pub use crate::weight::Weight;
use crate::with::with;
use crate::{Basis, Domains, ElementError, Frame, FrameDerivative, MaterialNode, Point};

/// What one evaluation needs: current positions, and the pairing data that stays fixed while differentiating.
///
/// ```
/// use diffuse_contact::{Basis, Element, Frame, Weight};
///
/// let masters: Vec<[f64; 3]> = (0..9).map(|k| [f64::from(k % 3), f64::from(k / 3), 0.0]).collect();
/// let frame = Frame::average_plane(&masters, [0.0, 0.0, 1.0])?;
/// // The paper's element: quadratic basis, cubic weight, one support radius.
/// let element = Element::new([1.1, 0.9, 0.25], &masters, frame, 2.0);
/// let other = element.with_weight(Weight::WendlandC2).with_basis(Basis::Linear);
/// # Ok::<(), diffuse_contact::ElementError>(())
/// ```
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Element<'a> {
    /// Slave node x^c.
    pub slave: Point,
    /// Master nodes x^1 … x^n.
    pub masters: &'a [Point],
    /// Local frame (t1, t2, n̂); n̂ points to the outward side of the master surface.
    pub frame: Frame,
    /// Radius R of the domain of influence around the slave, measured in the plane (t1, t2). With [`Domains::Each`] it is the length that
    /// offsets are divided by, and still bounds the search for the foot: one farther away is [`ElementError::FootOutside`].
    pub support_radius: f64,
    /// Radii of the nodes' own domains of influence.
    pub domains: Domains<'a>,
    /// Polynomial basis of the fit.
    pub basis: Basis,
    /// Weight function of the fit.
    pub weight: Weight,
}

impl<'a> Element<'a> {
    /// The paper's element: one domain of influence with the radius `support_radius` around the slave, quadratic basis, cubic
    /// weight.
    pub const fn new(slave: Point, masters: &'a [Point], frame: Frame, support_radius: f64) -> Self {
        Self {
            slave,
            masters,
            frame,
            support_radius,
            domains: Domains::Shared,
            basis: Basis::Quadratic,
            weight: Weight::Cubic,
        }
    }

    with! {
        /// With this basis.
        with_basis(basis: Basis);
        /// With this weight.
        with_weight(weight: Weight);
        /// With this frame.
        with_frame(frame: Frame);
        /// With these domains of influence.
        with_domains(domains: Domains<'a>);
    }

    /// Number of global coordinates the gap depends on, 3(n+1).
    pub const fn degrees_of_freedom(&self) -> usize {
        3 * (self.masters.len() + 1)
    }

    /// Index of the master node nearest to the slave in the plane (t1, t2), or in the first configuration, its distance over the radius of
    /// its domain; the first of several; 0 if there are none.
    ///
    /// # Panics
    /// If there are fewer domains than masters.
    pub fn nearest_in_plane(&self) -> usize {
        if let Domains::Material(nodes) = self.domains {
            return nearest_in_material(nodes);
        }
        let radius = |k: usize| self.domains.radius(k, self.support_radius);
        nearest_in_plane(self.slave, self.masters.iter().copied(), &self.frame, radius)
    }

    /// Checks what no kernel can repair: enough master nodes, finite input, positive radii, orthonormal
    /// frame.
    ///
    /// # Errors
    /// [`ElementError::NoKernels`] for a custom basis that can have none, [`ElementError::TooFewNodes`],
    /// [`ElementError::NonFiniteInput`], [`ElementError::InvalidSupportRadius`], [`ElementError::InvalidDomain`],
    /// [`ElementError::WrongNumberOfDomains`], [`ElementError::HeldFrame`], [`ElementError::NotMaterialPlace`],
    /// [`ElementError::InvalidReach`], [`ElementError::InvalidFrame`], [`ElementError::NotAveragePlane`],
    /// [`ElementError::AnisotropicBasis`].
    pub fn validate(&self) -> Result<(), ElementError> {
        self.validate_with(|r| self.weight.fitting(r))
    }

    /// As [`validate`](Self::validate), for a backend with a weight of its own, ω(r).
    ///
    /// # Errors
    /// As [`validate`](Self::validate).
    pub fn validate_with(&self, fitting_weight: impl Fn(f64) -> f64) -> Result<(), ElementError> {
        if !self.basis.is_sound() {
            return Err(ElementError::NoKernels { basis: self.basis.name() });
        }
        let needed = self.basis.size();
        if self.masters.len() < needed {
            return Err(ElementError::TooFewNodes { found: self.masters.len(), needed });
        }
        ElementError::check_points("slave", &[self.slave])?;
        ElementError::check_points("master", self.masters)?;
        if !is_radius(self.support_radius) {
            return Err(ElementError::InvalidSupportRadius { value: self.support_radius });
        }
        self.check_domains()?;
        if self.frame.derivative == FrameDerivative::CoMoving && !self.basis.is_isotropic() {
            return Err(ElementError::AnisotropicBasis { basis: self.basis.name() });
        }
        self.frame.check()?;
        let reach = self.frame.reach;
        if !(0.0..=1.0).contains(&reach) {
            return Err(ElementError::InvalidReach { value: reach });
        }
        if let Domains::Material(nodes) = self.domains {
            check_place(self.slave, self.masters, nodes, &self.frame, &fitting_weight)?;
            let weights = nodes.iter().map(|node| fitting_weight(node.distance()));
            return self.frame.check_average_plane(self.masters.iter().copied().zip(weights));
        }
        self.frame.check_average_plane(self.masters.iter().enumerate().map(|(k, &x)| {
            let weight = if reach == 0.0 {
                1.0
            } else {
                let distance = (Vector3::from(x) - Vector3::from(self.slave)).norm();
                fitting_weight(reach * distance / self.domains.radius(k, self.support_radius))
            };
            (x, weight)
        }))
    }

    /// As many domains as masters, each of them sound.
    fn check_domains(&self) -> Result<(), ElementError> {
        let expected = self.masters.len();
        let wrong = |found| ElementError::WrongNumberOfDomains { found, expected };
        match self.domains {
            Domains::Shared => {}
            Domains::Material(nodes) => {
                if nodes.len() != expected {
                    return Err(wrong(nodes.len()));
                }
                let is_finite =
                    |node: &MaterialNode| node.offset.iter().chain(&node.metric).all(|x| x.is_finite());
                if let Some(index) = nodes.iter().position(|node| !is_finite(node)) {
                    return Err(ElementError::NonFiniteInput { what: "domain", index });
                }
                if self.frame.derivative == FrameDerivative::Held {
                    return Err(ElementError::HeldFrame);
                }
            }
            Domains::Each(radii) => {
                if radii.len() != expected {
                    return Err(wrong(radii.len()));
                }
                if let Some(index) = radii.iter().position(|&radius| !is_radius(radius)) {
                    return Err(ElementError::InvalidDomain { index, value: radii[index] });
                }
            }
        }
        Ok(())
    }
}

fn is_radius(x: f64) -> bool {
    x.is_finite() && x > 0.0
}

/// Index of the node with the smallest distance over the radius of its domain; the first of several.
pub(crate) fn nearest_in_material(nodes: &[MaterialNode]) -> usize {
    let distances = nodes.iter().map(MaterialNode::distance).enumerate();
    distances.min_by(|x, y| x.1.total_cmp(&y.1)).map_or(0, |(index, _)| index)
}

/// As [`Element::nearest_in_plane`]; `radius`: of the k-th master's domain.
pub(crate) fn nearest_in_plane(
    slave: Point,
    masters: impl Iterator<Item = Point>,
    frame: &Frame,
    radius: impl Fn(usize) -> f64,
) -> usize {
    let square = |(k, master): (usize, Point)| {
        let offset = [master[0] - slave[0], master[1] - slave[1], master[2] - slave[2]];
        let along = |t: Point| (t[0] * offset[0] + t[1] * offset[1] + t[2] * offset[2]) / radius(k);
        let (a, b) = (along(frame.t1), along(frame.t2));
        (k, a * a + b * b)
    };
    let squares = masters.enumerate().map(square);
    squares.min_by(|x, y| x.1.total_cmp(&y.1)).map_or(0, |(index, _)| index)
}
