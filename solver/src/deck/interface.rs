//! `contact` and `[[interface]]`.

use diffuse_contact::interface::{ContactElement, InterfaceOptions};
use diffuse_contact::neighbourhood::{NeighbourRule, SearchOptions};
use diffuse_contact::pairing::{DEFAULT_NEIGHBOURS, MAX_NEIGHBOURS};
use diffuse_contact::surface::SymmetryPlane;
use diffuse_contact::{FrameDerivative, Weight};

use super::conditions::references;
use super::error::{DeckError, Problem};
use super::reader::{Field, Section, Source};
use super::{Reference, schema};

/// The element of every interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contact {
    /// The smooth surface through the master nodes.
    Diffuse,
    /// The classic element: the distance from the closest facet.
    NodeToFacet,
    /// None: interfaces are left out.
    None,
}

impl Contact {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Diffuse, Self::NodeToFacet, Self::None];

    /// Name in decks.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Diffuse => "diffuse",
            Self::NodeToFacet => "node-to-facet",
            Self::None => "none",
        }
    }
}

/// When slaves are paired with masters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refresh {
    /// At the beginning of each increment.
    Increment,
    /// In each iteration.
    Iteration,
}

/// The stiffness of contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tangent {
    /// The exact one, but ε N Nᵀ while the residual is large.
    Adaptive,
    /// ε (g M + N Nᵀ) (Chamoret et al. 2008, eq. 43).
    Exact,
    /// ε N Nᵀ.
    GaussNewton,
}

/// How often and how long multipliers are augmented.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Augmentation {
    /// Most augmentations in an increment, at least 1.
    pub max: usize,
    /// The largest penetration at which an increment is finished, length.
    pub tolerance: f64,
}

/// Surfaces that may touch.
#[derive(Clone, Debug, PartialEq)]
pub struct Interface {
    /// Line of the deck, from 1.
    pub line: usize,
    /// What it is called.
    pub name: String,
    /// Surfaces that carry the contact surface.
    pub master: Vec<Reference>,
    /// Surfaces whose nodes must not penetrate it.
    pub slave: Vec<Reference>,
    /// ε: force per penetration of a slave node; with areas pressure per penetration.
    pub penalty: f64,
    /// Whether ε is multiplied by the slave nodes' tributary areas at the start.
    pub areas: bool,
    /// `None`: penalty alone. Otherwise augmented Lagrangian.
    pub augmentation: Option<Augmentation>,
    /// Whether each side is slave of the other, each with half of the forces.
    pub two_pass: bool,
    /// Whether master and slave change places.
    pub exchange: bool,
    /// Weight of the diffuse element.
    pub weight: Weight,
    /// What the diffuse element's frame does while differentiating.
    pub frame: FrameDerivative,
    /// Which master nodes carry the smooth surface around a slave.
    pub neighbours: SearchOptions,
    /// Planes in which the master goes on as its mirror image.
    pub symmetry: Vec<SymmetryPlane>,
    /// When slaves are paired.
    pub refresh: Refresh,
    /// The stiffness of contact.
    pub tangent: Tangent,
    /// Angle between two facets up to which they belong to one smooth patch, degrees.
    pub feature_angle: f64,
    /// Slip over the support radius up to which a pairing is kept.
    pub hysteresis: f64,
    /// Distance beyond a border that still counts as on it, over the facet's height.
    pub border_tolerance: f64,
    /// Distance from the closest facet beyond which a slave is not paired, length.
    pub distance_limit: Option<f64>,
}

impl Interface {
    /// The options of its contact surfaces with this element; [`Contact::None`] has those of the diffuse element.
    #[must_use]
    pub fn options(&self, contact: Contact) -> InterfaceOptions {
        let element = match contact {
            Contact::NodeToFacet => ContactElement::NodeToFacet,
            Contact::Diffuse | Contact::None => {
                ContactElement::Diffuse { weight: self.weight, frame: self.frame, search: self.neighbours }
            }
        };
        InterfaceOptions {
            element,
            feature_angle_degrees: self.feature_angle,
            hysteresis: self.hysteresis,
            border_tolerance: self.border_tolerance,
            distance_limit: self.distance_limit,
            areas: self.areas,
        }
    }
}

pub(super) fn contact(deck: &Section) -> Result<Contact, DeckError> {
    let words = Contact::ALL.map(|contact| (contact.name(), contact));
    deck.get("contact").map_or(Ok(Contact::Diffuse), |field| field.word(&words))
}

pub(super) fn interface(section: Section) -> Result<Interface, DeckError> {
    let section = section.expect(schema::INTERFACE)?;
    let defaults = InterfaceOptions::default();
    let flag = |field| section.get(field).map_or(Ok(false), |field| field.flag());
    let weights = Weight::ALL.map(|weight| (weight.name(), weight));
    let frames = [("co-moving", FrameDerivative::CoMoving), ("frozen", FrameDerivative::Frozen)];
    let refreshes = [("increment", Refresh::Increment), ("iteration", Refresh::Iteration)];
    let tangents =
        [("adaptive", Tangent::Adaptive), ("exact", Tangent::Exact), ("gauss-newton", Tangent::GaussNewton)];
    let fraction = |field, default| match section.get(field) {
        Some(field) => field.number_in("at least 0", |value| value >= 0.0),
        None => Ok(default),
    };
    let name = section.need("name")?;
    let angle =
        |field: Field| field.number_in("from 0 to 180 degrees", |value| (0.0..=180.0).contains(&value));
    Ok(Interface {
        line: name.line(),
        name: name.text()?,
        master: references(&section.need("master")?)?,
        slave: references(&section.need("slave")?)?,
        penalty: section.need("penalty")?.positive()?,
        areas: flag("areas")?,
        augmentation: augmentation(&section)?,
        two_pass: flag("two_pass")?,
        exchange: flag("exchange")?,
        weight: section.get("weight").map_or(Ok(Weight::default()), |field| field.word(&weights))?,
        frame: section.get("frame").map_or(Ok(FrameDerivative::CoMoving), |field| field.word(&frames))?,
        neighbours: section
            .get("neighbours")
            .map_or(Ok(SearchOptions::domains()), |field| neighbours(&field))?,
        symmetry: section.get("symmetry").map_or(Ok(Vec::new()), |field| symmetry(&field))?,
        refresh: section.get("refresh").map_or(Ok(Refresh::Increment), |field| field.word(&refreshes))?,
        tangent: section.get("tangent").map_or(Ok(Tangent::Adaptive), |field| field.word(&tangents))?,
        feature_angle: section.get("feature_angle").map_or(Ok(defaults.feature_angle_degrees), angle)?,
        hysteresis: fraction("hysteresis", defaults.hysteresis)?,
        border_tolerance: fraction("border_tolerance", defaults.border_tolerance)?,
        distance_limit: section.get("distance_limit").map(|field| field.positive()).transpose()?,
    })
}

fn augmentation(section: &Section) -> Result<Option<Augmentation>, DeckError> {
    let methods = [("penalty", false), ("augmented-lagrangian", true)];
    if !section.get("method").map_or(Ok(false), |field| field.word(&methods))? {
        section.refuse(&["augmentation"], "without method = \"augmented-lagrangian\"")?;
        return Ok(None);
    }
    let section = section.need("augmentation")?.section()?.expect(schema::AUGMENTATION)?;
    Ok(Some(Augmentation {
        max: section.get("max").map_or(Ok(10), |field| field.positive_count())?,
        tolerance: section.need("tolerance")?.positive()?,
    }))
}

fn neighbours(field: &Field) -> Result<SearchOptions, DeckError> {
    let section = field.section()?.expect(schema::NEIGHBOURS)?;
    let count =
        section.get("count").map(|field| field.positive_count().map(|count| (field, count))).transpose()?;
    let layers = count.as_ref().map(|&(_, count)| count);
    let words = [
        ("domains", NeighbourRule::Domains),
        ("hull-layers", NeighbourRule::hull_layers(layers)),
        ("hull-radius", NeighbourRule::hull_radius(layers)),
        ("nearest", NeighbourRule::nearest(layers.unwrap_or(DEFAULT_NEIGHBOURS))),
    ];
    let rule = section.get("rule").map_or(Ok(NeighbourRule::Domains), |field| field.word(&words))?;
    if rule == NeighbourRule::Domains {
        section.refuse(&["count", "regularity"], "with rule = \"domains\"")?;
    }
    if let Some((field, count)) = count
        && count > MAX_NEIGHBOURS
    {
        return Err(field.out_of_range("from 1 to 24", count as f64));
    }
    let defaults = SearchOptions::default();
    let fraction =
        |field: Field| field.number_in("at least 0 and below 1", |value| (0.0..1.0).contains(&value));
    let smallest_regularity = section.get("regularity").map_or(Ok(defaults.smallest_regularity), fraction)?;
    Ok(SearchOptions { rule, smallest_regularity, ..defaults })
}

/// The names of global axes, for planes across them through the origin, or planes by a point and a normal towards the model.
fn symmetry(field: &Field) -> Result<Vec<SymmetryPlane>, DeckError> {
    let axes = [("x", 0), ("y", 1), ("z", 2)];
    let plane = |item: Field| match item.section() {
        Ok(section) => {
            let section = section.expect(schema::SYMMETRY)?;
            let normal = section.need("normal")?.vector()?;
            let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            if !(length > 0.0) {
                return Err(section.need("normal")?.out_of_range("a direction", length));
            }
            Ok(SymmetryPlane { point: section.need("point")?.vector()?, normal: normal.map(|x| x / length) })
        }
        Err(_) => Ok(SymmetryPlane::across(item.word(&axes)?, [0.0; 3])),
    };
    field.list("a list of axes or planes")?.into_iter().map(plane).collect()
}

/// Refuses two interfaces of one name.
pub(super) fn distinct(source: Source, interfaces: Vec<Interface>) -> Result<Vec<Interface>, DeckError> {
    for (k, later) in interfaces.iter().enumerate() {
        if let Some(other) = interfaces[..k].iter().find(|other| other.name == later.name) {
            let (name, other) = (later.name.clone(), other.line);
            let problem = Box::new(Problem::Repeated { what: "interface", name, other });
            return Err(DeckError::Invalid { path: source.path.into(), line: later.line, problem });
        }
    }
    Ok(interfaces)
}
