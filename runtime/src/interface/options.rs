//! What a contact interface is made of, and when it pairs anew.

use super::InterfaceError;
use crate::neighbourhood::SearchOptions;
use crate::{FrameDerivative, Weight};

/// The element of every slave node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactElement {
    /// The diffuse element: a smooth surface through the master nodes around the slave.
    Diffuse {
        /// Weight function of the fit.
        weight: Weight,
        /// [`FrameDerivative::CoMoving`]: the frame is the average plane of the masters at the positions of the
        /// evaluation. [`FrameDerivative::Frozen`]: it is the average plane of the last refresh.
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
        Self::Diffuse {
            weight: Weight::default(),
            frame: FrameDerivative::CoMoving,
            search: SearchOptions::domains(),
        }
    }
}

/// How a [`ContactInterface`](super::ContactInterface) pairs and evaluates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InterfaceOptions {
    /// The element of every slave node.
    pub element: ContactElement,
    /// Two facets belong to one smooth patch if the angle between their normals does not exceed this, in
    /// degrees from 0 to 180. A patch ends at sharper edges as it does at a border.
    pub feature_angle_degrees: f64,
    /// At a refresh a pairing that is otherwise sound is kept until the slave has slid along the master by this
    /// fraction of the support radius (node to facet: until it is off its facet by this fraction of the facet's
    /// extent); at least 0. With 0 every refresh pairs all slaves anew.
    pub hysteresis: f64,
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
    /// The default element, 45°, a hysteresis of 0.1, a border tolerance of 0.01, no distance limit, no areas.
    fn default() -> Self {
        Self {
            element: ContactElement::default(),
            feature_angle_degrees: 45.0,
            hysteresis: 0.1,
            border_tolerance: 0.01,
            distance_limit: None,
            areas: false,
        }
    }
}

impl InterfaceOptions {
    /// The options with the node-to-facet element.
    #[must_use]
    pub fn node_to_facet() -> Self {
        Self { element: ContactElement::NodeToFacet, ..Self::default() }
    }

    /// Checks that every option is in its range.
    ///
    /// # Errors
    /// [`InterfaceError::InvalidOption`], [`InterfaceError::InvalidSearch`].
    pub fn check(&self) -> Result<(), InterfaceError> {
        let invalid = |name, range, value| Err(InterfaceError::InvalidOption { name, range, value });
        if !(0.0..=180.0).contains(&self.feature_angle_degrees) {
            return invalid("feature_angle_degrees", "from 0 to 180", self.feature_angle_degrees);
        }
        for (name, value) in [("hysteresis", self.hysteresis), ("border_tolerance", self.border_tolerance)] {
            if !(value >= 0.0 && value.is_finite()) {
                return invalid(name, "at least 0 and finite", value);
            }
        }
        if let Some(limit) = self.distance_limit
            && !(limit > 0.0 && limit.is_finite())
        {
            return invalid("distance_limit", "positive and finite", limit);
        }
        if let ContactElement::Diffuse { search, .. } = &self.element {
            search.check()?;
        }
        Ok(())
    }
}
