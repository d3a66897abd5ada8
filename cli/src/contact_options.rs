//! The element of a whole interface, as it is asked for on the command line.

use clap::{Args, ValueEnum};
use diffuse_contact::interface::{ContactElement, InterfaceOptions};
use diffuse_contact::neighbourhood::{NeighbourRule, SearchOptions};
use diffuse_contact::pairing::DEFAULT_NEIGHBOURS;
use diffuse_contact::surface::SymmetryPlane;
use diffuse_contact::{FrameDerivative, Weight};
use serde::Serialize;

use crate::arguments::{named, named_or_left_out};
use crate::error::CliError;

/// What can be said about the element.
#[derive(Args, Clone, Debug)]
pub struct ElementArguments {
    /// Element of every slave node: the smooth surface, or the distance from the closest facet
    #[arg(long, value_enum, default_value_t = ElementName::Diffuse)]
    pub element: ElementName,
    /// Weight of the smooth surface [default: cubic]
    #[arg(long, value_parser = named_or_left_out(Weight::ALL, Weight::name, (Weight::LEFT_OUT, "interpolating")))]
    pub weight: Option<Weight>,
    /// What the local frame of the smooth surface does while differentiating [default: co-moving]
    #[arg(long, value_parser = named([FrameDerivative::CoMoving, FrameDerivative::Held], frame_name))]
    pub frame_derivative: Option<FrameDerivative>,
    /// Which master nodes carry the smooth surface around a slave [default: domains]
    #[arg(long, value_parser = named(RULES, rule_name))]
    pub rule: Option<NeighbourRule>,
    /// Planes across global axes, through the origin, in which the master goes on as its mirror image: x,y
    #[arg(long, value_name = "AXES", value_delimiter = ',', value_enum)]
    pub symmetry: Vec<Axis>,
    /// Angle between two facets, in degrees, up to which they belong to one sheet
    #[arg(long, value_name = "DEG", default_value_t = 45.0, value_parser = angle)]
    pub feature_angle: f64,
}

/// A global axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Axis {
    /// The first.
    X,
    /// The second.
    Y,
    /// The third.
    Z,
}

/// The elements by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ElementName {
    /// The diffuse element.
    Diffuse,
    /// The classic element.
    NodeToFacet,
}

/// The rules of the neighbour search with their defaults.
pub const RULES: [NeighbourRule; 4] = [
    NeighbourRule::Domains,
    NeighbourRule::hull_layers(None),
    NeighbourRule::hull_radius(None),
    NeighbourRule::nearest(DEFAULT_NEIGHBOURS),
];

impl ElementArguments {
    /// The symmetry planes.
    pub fn planes(&self) -> Vec<SymmetryPlane> {
        self.symmetry.iter().map(|&axis| SymmetryPlane::across(axis as usize, [0.0; 3])).collect()
    }

    /// The options of the interface.
    ///
    /// # Errors
    /// [`CliError::MeaninglessOption`] for an option of the smooth surface where there is none.
    pub fn options(&self) -> Result<InterfaceOptions, CliError> {
        let element = match self.element {
            ElementName::Diffuse => diffuse(
                self.weight.unwrap_or_default(),
                self.frame_derivative.unwrap_or(FrameDerivative::CoMoving),
                self.rule.unwrap_or(NeighbourRule::Domains),
            ),
            ElementName::NodeToFacet => {
                let given = [
                    ("--weight", self.weight.is_some()),
                    ("--frame-derivative", self.frame_derivative.is_some()),
                    ("--rule", self.rule.is_some()),
                ];
                if let Some((option, _)) = given.into_iter().find(|(_, given)| *given) {
                    return Err(CliError::MeaninglessOption { option, beside: "--element node-to-facet" });
                }
                ContactElement::NodeToFacet
            }
        };
        Ok(InterfaceOptions::default().with_element(element).with_feature_angle_degrees(self.feature_angle))
    }
}

/// A diffuse element with the defaults for what is not named.
pub fn diffuse(weight: Weight, frame: FrameDerivative, rule: NeighbourRule) -> ContactElement {
    ContactElement::diffuse(SearchOptions::default().with_rule(rule)).with_weight(weight).with_frame(frame)
}

/// An element in JSON and in words.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[allow(missing_docs)] // The names say what the fields are.
pub enum ElementDescription {
    /// The diffuse element.
    Diffuse { weight: &'static str, frame_derivative: &'static str, rule: &'static str },
    /// The classic element.
    NodeToFacet,
}

impl From<ContactElement> for ElementDescription {
    fn from(element: ContactElement) -> Self {
        match element {
            ContactElement::Diffuse { weight, frame, search, .. } => Self::Diffuse {
                weight: weight.name(),
                frame_derivative: frame_name(frame),
                rule: rule_name(search.rule),
            },
            ContactElement::NodeToFacet => Self::NodeToFacet,
        }
    }
}

impl std::fmt::Display for ElementDescription {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Diffuse { weight, frame_derivative, rule } => {
                write!(f, "diffuse: weight {weight}, frame {frame_derivative}, neighbours by {rule}")
            }
            Self::NodeToFacet => f.write_str("node-to-facet"),
        }
    }
}

/// Name of what a frame does.
pub const fn frame_name(frame: FrameDerivative) -> &'static str {
    match frame {
        FrameDerivative::CoMoving => "co-moving",
        FrameDerivative::Held => "held",
    }
}

/// Name of a rule, the same as in the JSON of `neighbours`.
pub const fn rule_name(rule: NeighbourRule) -> &'static str {
    match rule {
        NeighbourRule::Domains => "domains",
        NeighbourRule::HullLayers { .. } => "hull-layers",
        NeighbourRule::HullRadius { .. } => "hull-radius",
        NeighbourRule::Nearest { .. } => "nearest",
        _ => "other",
    }
}

/// An angle between facets.
fn angle(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(angle) if (0.0..=180.0).contains(&angle) => Ok(angle),
        _ => Err("not a number of degrees from 0 to 180".into()),
    }
}
