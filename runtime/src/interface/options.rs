//! What a contact interface is made of, and how it pairs.

use diffuse_contact_kernels::cubic::Cubic;
use diffuse_contact_kernels::support::KernelSet;

use super::InterfaceError;
use crate::assembly::AssemblyError;
use crate::neighbourhood::{Fallback, NeighbourRule, SearchOptions};
use crate::with::with;
use crate::{Basis, FrameDerivative, Weight};

/// The element of every slave node.
///
/// ```
/// use diffuse_contact::Weight;
/// use diffuse_contact::interface::{ContactElement, InterfaceOptions};
///
/// let element = ContactElement::default().with_weight(Weight::WendlandC2);
/// let options = InterfaceOptions::default().with_element(element).with_areas(true);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactElement {
    /// The diffuse element: a smooth surface through the master nodes around the slave. It is made by
    /// [`diffuse`](ContactElement::diffuse).
    #[non_exhaustive]
    Diffuse {
        /// Weight function of the fit.
        weight: Weight,
        /// [`FrameDerivative::CoMoving`]: the frame is the average plane of the masters at the positions of the
        /// evaluation. [`FrameDerivative::Held`]: it is the average plane of the last refresh.
        frame: FrameDerivative,
        /// Which nodes take part.
        search: SearchOptions,
    },
    /// The classic element: the distance from the closest facet. The facet is the pairing: it stays the slave's
    /// between two refreshes even if the slave slides off it, and is then extended beyond its edges.
    NodeToFacet,
}

impl Default for ContactElement {
    /// The diffuse element with the cubic weight, a co-moving frame and nodal domains of influence.
    fn default() -> Self {
        Self::diffuse(SearchOptions::domains())
    }
}

impl ContactElement {
    /// The diffuse element of the nodes that a search takes, with the cubic weight and a co-moving frame.
    pub fn diffuse(search: SearchOptions) -> Self {
        Self::Diffuse { weight: Weight::default(), frame: FrameDerivative::CoMoving, search }
    }

    /// With this weight function, if there is a fit.
    #[must_use]
    pub const fn with_weight(self, weight: Weight) -> Self {
        match self {
            Self::Diffuse { frame, search, .. } => Self::Diffuse { weight, frame, search },
            Self::NodeToFacet => self,
        }
    }

    /// With this frame, if there is a fit.
    #[must_use]
    pub const fn with_frame(self, frame: FrameDerivative) -> Self {
        match self {
            Self::Diffuse { weight, search, .. } => Self::Diffuse { weight, frame, search },
            Self::NodeToFacet => self,
        }
    }

    /// Polynomial degree of the smooth surface under a slave whose search had to give this up; 0 without a fit. A basis of the
    /// caller's counts as one of degree 2.
    pub const fn degree(&self, fallback: Fallback) -> u8 {
        match (self, fallback) {
            (Self::NodeToFacet, _) => 0,
            (Self::Diffuse { .. }, Fallback::Linear { .. }) => 1,
            (Self::Diffuse { search, .. }, _) => match search.basis {
                Basis::Linear => 1,
                _ => 2,
            },
        }
    }
}

/// How a [`ContactInterface`](super::ContactInterface) pairs and evaluates.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct InterfaceOptions {
    /// The element of every slave node.
    pub element: ContactElement,
    /// Two facets belong to one sheet if the angle between their normals does not exceed this, in
    /// degrees from 0 to 180. A sheet ends at sharper edges as it does at a border.
    pub feature_angle_degrees: f64,
    /// A foot counts as on the border until it lies beyond it by this fraction of the facet's height over the
    /// border edge; at least 0.
    pub border_tolerance: f64,
    /// A slave farther than this from the closest facet is not paired, length; positive.
    pub distance_limit: Option<f64>,
    /// Whether results carry the slave nodes' tributary areas, at the positions the interface was made with,
    /// instead of 1.
    pub areas: bool,
}

impl Default for InterfaceOptions {
    /// The default element, 45°, a border tolerance of 0.01, no distance limit, no areas.
    fn default() -> Self {
        Self {
            element: ContactElement::default(),
            feature_angle_degrees: 45.0,
            border_tolerance: 0.01,
            distance_limit: None,
            areas: false,
        }
    }
}

impl InterfaceOptions {
    /// The options with the node-to-facet element.
    pub fn node_to_facet() -> Self {
        Self { element: ContactElement::NodeToFacet, ..Self::default() }
    }

    with! {
        /// With this element.
        with_element(element: ContactElement);
        /// With this feature angle.
        with_feature_angle_degrees(feature_angle_degrees: f64);
        /// With this tolerance of the border.
        with_border_tolerance(border_tolerance: f64);
        /// With this limit of the distance.
        with_distance_limit(distance_limit: Option<f64>);
        /// With the slave nodes' tributary areas or without.
        with_areas(areas: bool);
    }

    /// Checks that every option is in its range.
    ///
    /// # Errors
    /// [`InterfaceError::InvalidOption`], [`InterfaceError::InvalidSearch`], [`InterfaceError::HeldFrame`].
    pub fn check(&self) -> Result<(), InterfaceError> {
        let invalid = |name, range, value| Err(InterfaceError::InvalidOption { name, range, value });
        if !(0.0..=180.0).contains(&self.feature_angle_degrees) {
            return invalid("feature_angle_degrees", "from 0 to 180", self.feature_angle_degrees);
        }
        if !(self.border_tolerance >= 0.0 && self.border_tolerance.is_finite()) {
            return invalid("border_tolerance", "at least 0 and finite", self.border_tolerance);
        }
        if let Some(limit) = self.distance_limit
            && !(limit > 0.0 && limit.is_finite())
        {
            return invalid("distance_limit", "positive and finite", limit);
        }
        if let ContactElement::Diffuse { search, frame, .. } = &self.element {
            search.check()?;
            if (search.rule, *frame) == (NeighbourRule::Domains, FrameDerivative::Held) {
                return Err(InterfaceError::HeldFrame);
            }
        }
        Ok(())
    }

    /// Whether slaves of an interface with these options can have friction.
    pub(super) fn check_friction(&self) -> Result<(), AssemblyError> {
        match self.element {
            ContactElement::NodeToFacet => Ok(()),
            ContactElement::Diffuse { search, .. } if search.rule != NeighbourRule::Domains => {
                Err(AssemblyError::NoAnchors)
            }
            ContactElement::Diffuse { .. } if Cubic::FRICTION => Ok(()),
            ContactElement::Diffuse { .. } => Err(AssemblyError::NoFrictionKernels),
        }
    }
}
