//! `contact` and `[[interface]]`.

use std::sync::Arc;

use diffuse_contact::faces::{FacePressures, FaceRule};
use diffuse_contact::friction::{DecayingCoefficient, TabulatedCoefficient};
use diffuse_contact::interface::{ContactElement, InterfaceOptions};
use diffuse_contact::neighbourhood::{NeighbourRule, SearchOptions};
use diffuse_contact::pairing::{DEFAULT_NEIGHBOURS, MAX_NEIGHBOURS};
use diffuse_contact::surface::SymmetryPlane;
use diffuse_contact::{FrameDerivative, Weight};

use super::conditions::references;
use super::error::{DeckError, Problem};
use super::reader::{Field, Section, Source};
use super::{Reference, schema};
use crate::contact::{Augmentation, Coefficient, Friction, Integration, RefreshRule, TangentRule};
use crate::named::named;

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

named!(Contact { Diffuse => "diffuse", NodeToFacet => "node-to-facet", None => "none" });

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
    /// Whether master and slave are the same surfaces, in contact with themselves and with one another.
    pub self_contact: bool,
    /// ε: force per penetration of a slave node; with areas pressure per penetration. `None`: pressure per penetration, by the stiffness
    /// of the softer body and the size of its facets.
    pub penalty: Option<f64>,
    /// `None`: penalty alone. Otherwise augmented Lagrangian.
    pub augmentation: Option<Augmentation>,
    /// Whether each side is slave of the other, each with half of the forces.
    pub two_pass: bool,
    /// Whether master and slave change places.
    pub exchange: bool,
    /// Its contact surfaces with the diffuse element.
    pub surface: InterfaceOptions,
    /// Slaves with a gap of at most this, either way, start in touch, length.
    pub adjust: Option<f64>,
    /// Planes in which the master goes on as its mirror image.
    pub symmetry: Vec<SymmetryPlane>,
    /// When slaves are paired.
    pub refresh: RefreshRule,
    /// The stiffness of contact.
    pub tangent: TangentRule,
    /// Coulomb friction.
    pub friction: Option<Friction>,
    /// What contact is integrated over.
    pub integration: Integration,
}

impl Interface {
    /// The options of its contact surfaces with this element; [`Contact::None`] has those of the diffuse element.
    pub fn options(&self, contact: Contact) -> InterfaceOptions {
        let mut surface = self.surface;
        // Without a penalty it is one per area.
        surface.areas |= self.penalty.is_none() && self.integration == Integration::Nodes;
        match contact {
            Contact::NodeToFacet => surface.with_element(ContactElement::NodeToFacet),
            Contact::Diffuse | Contact::None => surface,
        }
    }
}

pub(super) fn contact(deck: &Section) -> Result<Contact, DeckError> {
    deck.or("contact", Contact::Diffuse, |field| field.word(Contact::NAMED))
}

/// An interface of a deck with this element.
pub(super) fn interface(section: Section, contact: Contact) -> Result<Interface, DeckError> {
    let section = section.expect(schema::INTERFACE)?;
    let flag = |field| section.or(field, false, Field::flag);
    let name = section.need("name")?;
    let integration = section.or("integration", Integration::Nodes, integration)?;
    if integration != Integration::Nodes {
        section.refuse(&["areas", "neighbours", "refresh"], "with integration over faces")?;
        if let Some(Ok(friction)) = section.get("friction").map(|field| field.section()) {
            friction.refuse(&["symmetric"], "with integration over faces")?;
        }
    }
    if matches!(integration, Integration::Faces { pressures: FacePressures::Points, .. }) {
        let why = "with pressures of points, as multipliers belong to nodes";
        section.refuse(&["augmentation"], why)?;
    }
    check_pressures(&section, integration)?;
    let surface = surface(&section)?;
    let refresh = section.or("refresh", RefreshRule::default(), |field| field.word(RefreshRule::NAMED))?;
    let has_domains = matches!(surface.element, ContactElement::Diffuse { search, .. } if search.rule == NeighbourRule::Domains);
    if refresh == RefreshRule::Iteration && contact != Contact::NodeToFacet && has_domains {
        section.refuse(&["refresh"], "with nodal domains, by which slaves follow in every iteration")?;
    }
    let own = section.get("self");
    if own.is_some() {
        section.refuse(&["master", "slave", "two_pass", "exchange", "adjust"], "with self")?;
    }
    let [master, slave] = ["master", "slave"].map(|side| match &own {
        Some(own) => references(own),
        None => references(&section.need(side)?),
    });
    Ok(Interface {
        line: name.line(),
        name: name.text()?,
        master: master?,
        slave: slave?,
        self_contact: own.is_some(),
        penalty: penalty(&section)?,
        augmentation: augmentation(&section)?,
        two_pass: flag("two_pass")?,
        exchange: flag("exchange")?,
        surface,
        adjust: section.get("adjust").map(|field| field.positive()).transpose()?,
        symmetry: section.or("symmetry", Vec::new(), symmetry)?,
        refresh,
        tangent: section.or("tangent", TangentRule::default(), |field| field.word(TangentRule::NAMED))?,
        friction: section.get("friction").map(|field| friction(&field)).transpose()?,
        integration,
    })
}

/// Refuses what friction has in the unit of a pressure where slaves have forces alone.
fn check_pressures(section: &Section, integration: Integration) -> Result<(), DeckError> {
    let has_areas = section.or("areas", false, Field::flag)?;
    if integration != Integration::Nodes || section.get("penalty").is_none() || has_areas {
        return Ok(());
    }
    let reason =
        "over nodes with penalty and without `areas = true`, where there are forces and no pressures";
    let Some(Ok(friction)) = section.get("friction").map(|field| field.section()) else { return Ok(()) };
    friction.refuse(&["shear_limit"], reason)?;
    match friction.get("coefficient").map(|field| field.section()) {
        Some(Ok(coefficient)) => coefficient.refuse(&["pressures"], reason),
        _ => Ok(()),
    }
}

fn penalty(section: &Section) -> Result<Option<f64>, DeckError> {
    let given = section.get("penalty").map(|field| field.positive()).transpose()?;
    if given.is_none()
        && let Some(areas) = section.get("areas")
        && !areas.flag()?
    {
        section.refuse(&["areas"], "without penalty, which is per area then")?;
    }
    Ok(given)
}

fn surface(section: &Section) -> Result<InterfaceOptions, DeckError> {
    let mut options = InterfaceOptions::default();
    let search = section.or("neighbours", SearchOptions::domains(), neighbours)?;
    options.element = ContactElement::diffuse(search);
    if let Some(field) = section.get("weight") {
        let weights = Weight::ALL.map(|weight| (weight.name(), weight));
        let left_out = (Weight::LEFT_OUT, "interpolating");
        options.element = options.element.with_weight(field.word_or_left_out(&weights, left_out)?);
    }
    if let Some(field) = section.get("frame") {
        let frames = [("co-moving", FrameDerivative::CoMoving), ("held", FrameDerivative::Held)];
        options.element = options.element.with_frame(field.word(&frames)?);
    }
    section.set("areas", &mut options.areas, Field::flag)?;
    if let Some(field) = section.get("feature_angle") {
        let is_angle = |value| (0.0..=180.0).contains(&value);
        options.feature_angle_degrees = field.number_in("from 0 to 180 degrees", is_angle)?;
    }
    section.set("border_tolerance", &mut options.border_tolerance, |field| {
        field.number_in("at least 0", |value| value >= 0.0)
    })?;
    options.distance_limit = section.get("distance_limit").map(|field| field.positive()).transpose()?;
    Ok(options)
}

fn augmentation(section: &Section) -> Result<Option<Augmentation>, DeckError> {
    let methods = [("penalty", false), ("augmented-lagrangian", true)];
    if !section.or("method", false, |field| field.word(&methods))? {
        section.refuse(&["augmentation"], "without method = \"augmented-lagrangian\"")?;
        return Ok(None);
    }
    rounds(&section.need_table("augmentation")?).map(Some)
}

/// A tolerance, and how many rounds there are at most.
fn rounds(field: &Field) -> Result<Augmentation, DeckError> {
    let section = field.section()?.expect(schema::AUGMENTATION)?;
    let mut augmentation = Augmentation::new(section.need("tolerance")?.positive()?);
    section.set("max", &mut augmentation.max_rounds, Field::positive_count)?;
    Ok(augmentation)
}

/// A coefficient, or a table with one.
fn friction(field: &Field) -> Result<Friction, DeckError> {
    let Ok(section) = field.section() else { return Ok(Friction::new(constant(field)?)) };
    let section = section.expect(schema::FRICTION)?;
    let stiffness = section.get("stiffness").map(|field| field.positive()).transpose()?;
    let is_symmetric = section.or("symmetric", false, Field::flag)?;
    let limit = section.get("shear_limit").map(|field| field.positive()).transpose()?;
    let augmentation = section.get("augmentation").map(|field| rounds(&field)).transpose()?;
    let friction = Friction::new(coefficient(&section.need("coefficient")?)?)
        .with_stiffness(stiffness)
        .with_shear_limit(limit)
        .with_augmentation(augmentation);
    Ok(friction.with_symmetric_tangent(is_symmetric))
}

fn constant(field: &Field) -> Result<Coefficient, DeckError> {
    Ok(Coefficient::Constant(at_least_0(field)?))
}

fn at_least_0(field: &Field) -> Result<f64, DeckError> {
    field.number_in("at least 0", |value| value >= 0.0)
}

/// A number, what it decays from and to, or a table of pressures and slip rates.
fn coefficient(field: &Field) -> Result<Coefficient, DeckError> {
    let Ok(section) = field.section() else { return constant(field) };
    let section = section.expect(schema::COEFFICIENT)?;
    let refused = |error| field.error(Problem::Coefficient { field: field.name().into(), error });
    if section.get("values").is_none() {
        section.refuse(&["pressures", "rates"], "without values")?;
        let number = |name| at_least_0(&section.need(name)?);
        let law = DecayingCoefficient::new(number("static")?, number("kinetic")?, number("decay")?);
        return Ok(Coefficient::Decaying(law.map_err(refused)?));
    }
    section.refuse(&["static", "kinetic", "decay"], "beside values")?;
    let axis = |name: &str| section.or(name, vec![0.0], ascending);
    let (pressures, rates) = (axis("pressures")?, axis("rates")?);
    let values = coefficients(&section.need("values")?, pressures.len(), rates.len())?;
    let law = TabulatedCoefficient::new(&pressures, &rates, &values).map_err(refused)?;
    Ok(Coefficient::Tabulated(Arc::new(law)))
}

/// A row of coefficients for each pressure, of one for each rate. Without rows all of them one after another.
fn coefficients(values: &Field, pressures: usize, rates: usize) -> Result<Vec<f64>, DeckError> {
    let of_rates = format!("{rates} numbers, one for each rate");
    let of_pressures = |what: &str| format!("{pressures} {what}, one for each pressure");
    let rows = values.list("a list of numbers, or of one row for each pressure")?;
    if !rows.first().is_some_and(Field::is_list) {
        if rows.len() == pressures * rates {
            return rows.iter().map(at_least_0).collect();
        }
        return Err(values.wrong_type(match (pressures, rates) {
            (1, _) => of_rates,
            (_, 1) => of_pressures("numbers"),
            _ => of_pressures("rows"),
        }));
    }
    if rows.len() != pressures {
        return Err(values.wrong_type(of_pressures("rows")));
    }
    let mut all = Vec::new();
    for row in &rows {
        let row_values = row.list("a list of numbers")?;
        if row_values.len() != rates {
            return Err(row.wrong_type(of_rates));
        }
        for value in &row_values {
            all.push(at_least_0(value)?);
        }
    }
    Ok(all)
}

/// At least one number, each larger than the one before.
fn ascending(field: &Field) -> Result<Vec<f64>, DeckError> {
    let list = field.list("a list of numbers")?;
    if list.is_empty() {
        return Err(field.wrong_type("a list of at least one number"));
    }
    let numbers: Vec<f64> = list.iter().map(Field::number).collect::<Result<_, _>>()?;
    match numbers.windows(2).position(|pair| !(pair[0] < pair[1])) {
        Some(before) => {
            let (field_name, index) = (field.name().into(), before + 1);
            Err(field.error(Problem::Descending { field: field_name, index }))
        }
        None => Ok(numbers),
    }
}

/// `"nodes"` or `"faces"`, or a table with the degree of the faces' rule.
fn integration(field: &Field) -> Result<Integration, DeckError> {
    let section = match field.section() {
        Ok(section) => Some(section.expect(schema::INTEGRATION)?),
        Err(_) => None,
    };
    let words = [("nodes", Integration::Nodes), ("faces", Integration::FACES)];
    let Some(section) = section else { return field.word(&words) };
    let over = section.need("over")?.word(&words)?;
    if over == Integration::Nodes {
        section.refuse(&["degree", "pressures"], "with over = \"nodes\"")?;
        return Ok(over);
    }
    let rule = section.or("degree", FaceRule::default(), |degree| {
        let found = degree.positive_count()?;
        let rule = FaceRule::ALL.into_iter().find(|rule| rule.degree() == found);
        rule.ok_or_else(|| degree.out_of_range("2 or 4", found as f64))
    })?;
    let words = FacePressures::ALL.map(|pressures| (pressures.name(), pressures));
    let pressures = section.or("pressures", FacePressures::default(), |field| field.word(&words))?;
    Ok(Integration::Faces { rule, pressures })
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
    let rule = section.or("rule", NeighbourRule::Domains, |field| field.word(&words))?;
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
        |field: &Field| field.number_in("at least 0 and below 1", |value| (0.0..1.0).contains(&value));
    let smallest_regularity = section.or("regularity", defaults.smallest_regularity, fraction)?;
    Ok(defaults.with_rule(rule).with_smallest_regularity(smallest_regularity))
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
