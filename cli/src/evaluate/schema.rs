//! What `evaluate` reads.
//!
//! ```json
//! {"elements": [{
//!   "slave": [0.1, 0.2, 0.3],
//!   "masters": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]],
//!   "outward": [0, 0, 1],
//!   "frame": "average-plane",
//!   "frame_derivative": "co-moving",
//!   "support_radius": 2.0,
//!   "support_radii": [2.0, 2.1, 1.9, 2.0],
//!   "first_positions": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]],
//!   "metrics": [[[4, 0, 0], [0, 4, 0], [0, 0, 4]], …],
//!   "basis": "linear",
//!   "weight": "cubic",
//!   "penalty": 1.0,
//!   "anchor": [0.05, 0.2, 0.0],
//!   "friction": {"coefficient": 0.3, "stiffness": 1.0, "shear_limit": 2.0}   // the limit may be left out
//! }]}
//! ```
//!
//! Only `slave` and `masters` are always needed. Of `support_radius` and `support_radii` on one hand, `first_positions` and `metrics` on the
//! other, an element has one pair at most. The defaults are those of [`ElementInput`]'s fields. Nothing else
//! is accepted: a field the program does not know is an error, not ignored. All coordinates are global, in one
//! length unit of the caller's choice; the penalty is force per length.

use std::fmt;

use diffuse_contact::{Basis, FrameDerivative, Point, Weight};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, MapAccess, Unexpected, Visitor};

use crate::error::CliError;
use crate::json::{self, BasisName, Coordinates, Object};

/// The whole file.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Document {
    /// The elements, evaluated in this order.
    pub elements: Vec<Object<ElementInput>>,
}

/// One element.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ElementInput {
    /// Slave node.
    pub slave: Coordinates,
    /// Master nodes.
    pub masters: Vec<Coordinates>,
    /// A direction to the outward side of the master surface, of any length. Needed for the average plane; with a
    /// given frame it turns the normal to its side.
    pub outward: Option<Coordinates>,
    /// The local frame; the average plane of the masters if left out.
    #[serde(default)]
    pub frame: FrameInput,
    /// What the frame does while the gap is differentiated; if left out, `co-moving` for the average plane and
    /// `held` for a given frame, which does not move with the nodes.
    frame_derivative: Option<FrameDerivativeInput>,
    /// Radius of the domain of influence; 1.25 × the farthest in-plane distance of a master if left out.
    pub support_radius: Option<f64>,
    /// Radii of the masters' own domains of influence, one for each; the average plane then weights its nodes. If left out all have
    /// the support radius, and the plane weights none, as in the paper.
    pub support_radii: Option<Vec<f64>>,
    /// First positions X_k of the masters. With `metrics` the domains of influence are those of an interface, ellipsoids in the first
    /// configuration.
    pub first_positions: Option<Vec<Coordinates>>,
    /// A symmetric matrix C for each master: its domain is (X − X_k)ᵀ C⁻¹ (X − X_k) < 1. The eigenvalues are half axes squared.
    pub metrics: Option<Vec<Metric>>,
    /// Basis of the fit; quadratic from six masters on, linear below, if left out.
    basis: Option<BasisName>,
    /// Weight of the fit; `cubic` if left out.
    #[serde(default, deserialize_with = "weight")]
    pub weight: Weight,
    /// Penalty ε of the force and the tangent; 1 if left out.
    #[serde(default = "unit_penalty")]
    pub penalty: f64,
    /// Where the anchor is that the slip is measured from; without it there is no slip.
    pub anchor: Option<Coordinates>,
    /// Coulomb's friction; needs the anchor.
    pub friction: Option<FrictionInput>,
}

/// Coulomb's law with a penalty for stick.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionInput {
    /// Coefficient of friction μ ≥ 0.
    pub coefficient: f64,
    /// Tangential stiffness ε_T > 0, force per length.
    pub stiffness: f64,
    /// Force τ > 0 that no contact exceeds.
    pub shear_limit: Option<f64>,
}

impl ElementInput {
    /// Positions of the masters.
    pub fn masters(&self) -> Vec<Point> {
        self.masters.iter().map(|master| master.0).collect()
    }

    /// The motion of the frame asked for, or the default for this frame.
    pub fn frame_derivative(&self) -> FrameDerivative {
        match (self.frame_derivative, &self.frame) {
            (Some(FrameDerivativeInput::Held), _) | (None, FrameInput::Given(_)) => FrameDerivative::Held,
            (Some(FrameDerivativeInput::CoMoving), _) | (None, FrameInput::AveragePlane) => {
                FrameDerivative::CoMoving
            }
        }
    }

    /// The basis asked for, or the default for this number of masters.
    pub fn basis(&self) -> Basis {
        match self.basis {
            Some(basis) => basis.into(),
            None if self.masters.len() >= Basis::Quadratic.size() => Basis::Quadratic,
            None => Basis::Linear,
        }
    }
}

/// A 3×3 matrix by rows.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(try_from = "Vec<Coordinates>")]
pub struct Metric(pub [Point; 3]);

impl TryFrom<Vec<Coordinates>> for Metric {
    type Error = WrongRows;

    fn try_from(rows: Vec<Coordinates>) -> Result<Self, WrongRows> {
        let found = rows.len();
        let rows: [Coordinates; 3] = rows.try_into().map_err(|_| WrongRows { found })?;
        Ok(Self(rows.map(|Coordinates(row)| row)))
    }
}

/// A matrix with a number of rows other than three.
#[derive(Debug, thiserror::Error)]
#[error("expected three rows [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], found {found}")]
pub struct WrongRows {
    found: usize,
}

const fn unit_penalty() -> f64 {
    1.0
}

/// The local frame.
#[derive(Debug, Default, PartialEq)]
pub enum FrameInput {
    /// The word `"average-plane"`.
    #[default]
    AveragePlane,
    /// The frame itself.
    Given(GivenFrame),
}

/// A local frame written out.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GivenFrame {
    /// A point of the plane.
    pub origin: Coordinates,
    /// First direction in the plane.
    pub t1: Coordinates,
    /// Second direction in the plane.
    pub t2: Coordinates,
    /// Normal of the plane.
    pub normal: Coordinates,
}

/// The one word for a frame.
const AVERAGE_PLANE: &str = "average-plane";

impl<'de> Deserialize<'de> for FrameInput {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(FrameVisitor)
    }
}

struct FrameVisitor;

impl<'de> Visitor<'de> for FrameVisitor {
    type Value = FrameInput;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "\"{AVERAGE_PLANE}\" or an object with origin, t1, t2 and normal")
    }

    fn visit_str<E: serde::de::Error>(self, word: &str) -> Result<FrameInput, E> {
        if word == AVERAGE_PLANE {
            Ok(FrameInput::AveragePlane)
        } else {
            Err(E::invalid_value(Unexpected::Str(word), &self))
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<FrameInput, A::Error> {
        Deserialize::deserialize(MapAccessDeserializer::new(map)).map(FrameInput::Given)
    }
}

#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
enum FrameDerivativeInput {
    Held,
    CoMoving,
}

#[derive(Clone, Copy, Debug, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
enum WeightInput {
    Cubic,
    CubicInterpolating,
    WendlandC2,
}

/// A weight by its name.
fn weight<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Weight, D::Error> {
    let name = match WeightInput::deserialize(deserializer)? {
        WeightInput::Cubic => "cubic",
        WeightInput::CubicInterpolating => "cubic-interpolating",
        WeightInput::WendlandC2 => "wendland-c2",
    };
    named(&Weight::ALL, name).map_err(D::Error::custom)
}

/// The weight among those of this build.
fn named(built: &[Weight], name: &str) -> Result<Weight, String> {
    let found = built.iter().find(|weight| weight.name() == name).copied();
    found.ok_or_else(|| format!("{name} needs a program built with --features interpolating"))
}

/// Reads a document, or says in one sentence where it departs from the schema.
pub fn parse(file: &str, text: &[u8]) -> Result<Document, CliError> {
    json::parse(file, text).map(|Object(document)| document)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_weight_of_other_builds_is_refused_with_its_feature() {
        let built = [Weight::Cubic, Weight::WendlandC2];
        assert_eq!(named(&built, "wendland-c2"), Ok(Weight::WendlandC2));
        assert!(named(&built, "cubic-interpolating").unwrap_err().contains("--features interpolating"));
        // Every name that the schema has is that of a weight, or of one left out.
        let of_schema = ["cubic", "cubic-interpolating", "wendland-c2"];
        let known: Vec<&str> =
            Weight::ALL.map(Weight::name).iter().chain(Weight::LEFT_OUT).copied().collect();
        assert!(known.len() == of_schema.len() && of_schema.iter().all(|name| known.contains(name)));
    }

    fn refusal(text: &str) -> String {
        parse("in.json", text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn the_defaults_are_the_documented_ones() {
        let text = r#"{"elements": [{"slave": [0, 0, 1], "masters": [[1, 2, 3]]}]}"#;
        let document = parse("in.json", text.as_bytes()).unwrap();
        let element = &document.elements[0].0;
        assert_eq!(element.slave, Coordinates([0.0, 0.0, 1.0]));
        assert_eq!(element.masters(), [[1.0, 2.0, 3.0]]);
        assert_eq!((element.outward, element.support_radius), (None, None));
        assert_eq!(element.frame, FrameInput::AveragePlane);
        assert_eq!(element.frame_derivative(), FrameDerivative::CoMoving);
        assert_eq!((element.basis(), element.weight), (Basis::Linear, Weight::Cubic));
        assert_eq!(element.penalty, 1.0);
    }

    #[test]
    fn a_frame_can_be_written_out() {
        let text = r#"{"elements": [{"slave": [0, 0, 1], "masters": [], "frame":
            {"origin": [0, 0, 0], "t1": [1, 0, 0], "t2": [0, 1, 0], "normal": [0, 0, 1]}}]}"#;
        let document = parse("in.json", text.as_bytes()).unwrap();
        let element = &document.elements[0].0;
        let FrameInput::Given(frame) = &element.frame else { panic!("average plane") };
        assert_eq!(frame.t2, Coordinates([0.0, 1.0, 0.0]));
        assert_eq!(element.frame_derivative(), FrameDerivative::Held);
    }

    #[test]
    fn the_motion_of_the_frame_can_be_chosen() {
        for (word, expected) in [("held", FrameDerivative::Held), ("co-moving", FrameDerivative::CoMoving)] {
            let text = format!(
                r#"{{"elements": [{{"slave": [0, 0, 1], "masters": [], "frame_derivative": "{word}"}}]}}"#
            );
            let document = parse("in.json", text.as_bytes()).unwrap();
            assert_eq!(document.elements[0].0.frame_derivative(), expected);
        }
    }

    #[test]
    fn a_misspelt_field_is_named_with_its_neighbour() {
        let message = refusal("{\"elements\": [\n {\"slave\": [0,0,0], \"support_raduis\": 1}]}");
        assert!(message.starts_with("in.json, line 2, column "), "{message}");
        assert!(message.contains("elements[0].support_raduis: unknown field `support_raduis`"), "{message}");
        assert!(message.ends_with("did you mean `support_radius`?"), "{message}");
        assert!(!refusal(r#"{"elements": [], "comment": 1}"#).contains("did you mean"));
    }

    #[test]
    fn the_place_of_a_wrong_value_is_named() {
        for (text, expected) in [
            (r#"{"elements": [{"slave": [0, "a", 0]}]}"#, "elements[0].slave[1]: invalid type: string \"a\""),
            (
                r#"{"elements": [{"slave": [0, 1]}]}"#,
                "elements[0].slave: expected three coordinates [x, y, z], found 2",
            ),
            (r#"{"elements": [{"slave": [0, 1, 2, 3]}]}"#, "[x, y, z], found 4"),
            (r#"{"elements": [{"slave": [0, 1, 1e999]}]}"#, "elements[0].slave[2]: number out of range"),
            (r#"{"elements": [{"slave": [0, 1, NaN]}]}"#, "elements[0].slave[2]: NaN is no number in JSON"),
            (
                r#"{"elements": [{"slave": [-Infinity, 1, 2]}]}"#,
                "elements[0].slave[0]: Infinity is no number in JSON",
            ),
            (r#"{"elements": [{"slave": [nan, 1, 2]}]}"#, "elements[0].slave[0]: nan is no number in JSON"),
            (
                r#"{"elements": [{"slave": [0, 1,, 2]}]}"#,
                "elements[0].slave[2]: not valid JSON: expected value",
            ),
            (r#"{"elements": [{"slave": [0, 1, null]}]}"#, "elements[0].slave[2]: invalid type: null"),
            (r#"{"elements": [{"slave": [0, 1, 2]}]}"#, "elements[0]: missing field `masters`"),
            (
                r#"{"elements": [{"basis": "cubic"}]}"#,
                "elements[0].basis: unknown variant `cubic`, expected `quadratic` or `linear`",
            ),
            (
                r#"{"elements": [{"weight": "gauss"}]}"#,
                "elements[0].weight: unknown variant `gauss`, expected one of `cubic`, `cubic-interpolating`, `wendland-c2`",
            ),
            (
                r#"{"elements": [{"frame_derivative": "moving"}]}"#,
                "elements[0].frame_derivative: unknown variant `moving`, expected `held` or `co-moving`",
            ),
            (
                r#"{"elements": [{"frame": "plane"}]}"#,
                "elements[0].frame: invalid value: string \"plane\", expected \"average-plane\" or an object",
            ),
            (r#"{"elements": [{"frame": {"origin": [0, 0]}}]}"#, "elements[0].frame.origin: expected three"),
            (r#"{"elements": [{"penalty": "1"}]}"#, "elements[0].penalty: invalid type"),
            (r#"{"elements": [{"slave": [0,0,0], "slave": [0,0,0]}]}"#, "duplicate field `slave`"),
            (r#"{"elements": []} x"#, "not valid JSON: trailing characters"),
            (r#"{"elements": 3}"#, "elements: invalid type: integer `3`, expected a sequence"),
            ("", "line 1, column 0: not valid JSON: EOF while parsing a value"),
            ("{\"elements\":\n [ \n\n", "line 2, column 2: elements: not valid JSON: EOF"),
            ("[1]", "line 1, column 0: invalid type: sequence, expected an object"),
            ("[[]]", "expected an object"),
            (
                r#"{"elements": [[[0, 0, 1], [[0, 0, 0]]]]}"#,
                "elements[0]: invalid type: sequence, expected an object",
            ),
            (
                r#"{"elements": [{"frame": [[0, 0, 0]]}]}"#,
                "elements[0].frame: invalid type: sequence, expected \"average-plane\" or",
            ),
        ] {
            let message = refusal(text);
            assert!(message.contains(expected), "{text}: {message}");
            assert!(!message.contains('\n'), "{message}");
        }
    }
}
