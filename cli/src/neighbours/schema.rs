//! What `neighbours` reads.
//!
//! ```json
//! {"slave": [0.1, 0.2, 0.3],
//!  "masters": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]],
//!  "outward": [0, 0, 1],
//!  "rule": "hull-layers",
//!  "layers": 1}
//! ```
//!
//! or a list of such objects, or what `evaluate` reads, `{"elements": [...]}`, whose fields on the element are passed over. `slave` and
//! `masters` are always needed, and so is `outward`, for which the normal of an element's frame stands in. The defaults are those of
//! [`SearchInput`]'s fields. Nothing else is accepted. All coordinates are global, in one length unit.

use std::fmt;

use diffuse_contact::{Basis, Point};
use serde::Serialize;
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};

use crate::error::CliError;
use crate::evaluate::schema::FrameInput;
use crate::json::{self, BasisName, Coordinates, Object};

/// The whole file.
#[derive(Debug)]
pub struct Document {
    /// The searches, made in this order.
    pub searches: Vec<Object<SearchInput>>,
    /// How they stand in the file.
    pub layout: Layout,
}

/// How searches stand in a file, and their results in another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// One by itself.
    One,
    /// In a list.
    List,
    /// In the list `elements`, as `evaluate` has them.
    Elements,
}

impl Layout {
    /// The name of a search in a message, with what goes between it and a field of it.
    pub fn place(self, index: usize) -> String {
        match self {
            Self::One => String::new(),
            Self::List => format!("[{index}]."),
            Self::Elements => format!("elements[{index}]."),
        }
    }
}

/// One search.
#[derive(Debug, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SearchInput {
    /// Slave node.
    pub slave: Coordinates,
    /// Master nodes.
    masters: Vec<Coordinates>,
    outward: Option<Coordinates>,
    /// Which nodes take part; `hull-layers` if left out.
    #[serde(default)]
    pub rule: Rule,
    /// Number of hull layers: exactly so many for `hull-layers`, at least so many for `hull-radius`; as many as make the
    /// fit well conditioned if left out.
    pub layers: Option<Count>,
    /// Number of nodes to start from for `nearest`; the library's default if left out.
    pub count: Option<Count>,
    /// Basis the nodes are to carry; `quadratic`, and `linear` where no nodes carry that, if left out.
    pub basis: Option<BasisName>,
    frame: Option<FrameInput>,
    frame_derivative: Option<IgnoredAny>,
    support_radius: Option<IgnoredAny>,
    support_radii: Option<IgnoredAny>,
    first_positions: Option<IgnoredAny>,
    metrics: Option<IgnoredAny>,
    weight: Option<IgnoredAny>,
    penalty: Option<IgnoredAny>,
    anchor: Option<IgnoredAny>,
    friction: Option<IgnoredAny>,
}

/// One search that is no element.
#[derive(serde::Deserialize)]
#[serde(try_from = "SearchInput")]
struct Search(SearchInput);

impl TryFrom<SearchInput> for Search {
    type Error = &'static str;

    fn try_from(input: SearchInput) -> Result<Self, Self::Error> {
        if input.outward.is_some() { Ok(Self(input)) } else { Err("missing field `outward`") }
    }
}

impl SearchInput {
    /// A field that only an element has.
    pub fn field_of_element(&self) -> Option<&'static str> {
        let fields = [
            ("frame", self.frame.is_some()),
            ("frame_derivative", self.frame_derivative.is_some()),
            ("support_radius", self.support_radius.is_some()),
            ("support_radii", self.support_radii.is_some()),
            ("first_positions", self.first_positions.is_some()),
            ("metrics", self.metrics.is_some()),
            ("weight", self.weight.is_some()),
            ("penalty", self.penalty.is_some()),
            ("anchor", self.anchor.is_some()),
            ("friction", self.friction.is_some()),
        ];
        fields.into_iter().find(|(_, is_given)| *is_given).map(|(name, _)| name)
    }

    /// A direction to the outward side of the master surface, of any length: that given, or the normal of an element's frame.
    pub fn outward(&self) -> Option<Point> {
        let of_frame = match &self.frame {
            Some(FrameInput::Given(frame)) => Some(frame.normal),
            _ => None,
        };
        self.outward.or(of_frame).map(|direction| direction.0)
    }

    /// Positions of the masters.
    pub fn masters(&self) -> Vec<Point> {
        self.masters.iter().map(|master| master.0).collect()
    }

    /// The basis to try first.
    pub fn basis(&self) -> Basis {
        self.basis.map_or(Basis::Quadratic, Basis::from)
    }
}

/// Which nodes take part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rule {
    /// Those of the first hull layers.
    #[default]
    HullLayers,
    /// All inside the support radius that the hull layers set.
    HullRadius,
    /// The nearest.
    Nearest,
}

/// A number of things of which there is to be one at least.
#[derive(Clone, Copy, Debug, PartialEq, serde::Deserialize)]
#[serde(try_from = "u64")]
pub struct Count(pub usize);

impl TryFrom<u64> for Count {
    type Error = &'static str;

    fn try_from(number: u64) -> Result<Self, Self::Error> {
        match usize::try_from(number) {
            Ok(0) => Err("expected at least 1, found 0"),
            Ok(number) => Ok(Self(number)),
            Err(_) => Err("more than this machine can count"),
        }
    }
}

impl<'de> Deserialize<'de> for Document {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(DocumentVisitor)
    }
}

struct DocumentVisitor;

impl<'de> Visitor<'de> for DocumentVisitor {
    type Value = Document;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object with slave, masters and outward, a list of such objects, or {\"elements\": [...]} as for evaluate")
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Document, A::Error> {
        let Search(search) = Search::deserialize(MapAccessDeserializer::new(map))?;
        Ok(Document { searches: vec![Object(search)], layout: Layout::One })
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<Document, A::Error> {
        let searches = Vec::<Object<Search>>::deserialize(SeqAccessDeserializer::new(list))?;
        let searches = searches.into_iter().map(|Object(Search(search))| Object(search)).collect();
        Ok(Document { searches, layout: Layout::List })
    }
}

/// What `evaluate` reads.
#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Elements {
    elements: Vec<Object<SearchInput>>,
}

/// Reads a document, or says in one sentence where it departs from the schema.
pub fn parse(file: &str, text: &[u8]) -> Result<Document, CliError> {
    let first_key =
        json::without_mark(text).trim_ascii_start().strip_prefix(b"{").map(<[u8]>::trim_ascii_start);
    if first_key.is_some_and(|key| key.starts_with(b"\"elements\"")) {
        let Object(Elements { elements }) = json::parse(file, text)?;
        return Ok(Document { searches: elements, layout: Layout::Elements });
    }
    json::parse(file, text)
}
