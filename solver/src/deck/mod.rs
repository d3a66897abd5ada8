//! Decks: a problem in TOML, every field checked.
//!
//! [`Deck::read`] checks all that can be said about the text: fields, types, ranges. [`Deck::model`] makes the parts and
//! resolves every name. What is wrong is a [`DeckError`] with file, line, field and number. `docs/how-to/decks.md` lists all fields
//! with units and defaults; the types here hold them after checking.
//!
//! Any consistent units will do: a length, a force, and stresses in force per length².

mod conditions;
mod contacts;
mod control;
mod error;
mod interface;
mod parts;
mod reader;
mod resolve;
pub mod schema;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use diffuse_contact_mesh::ElementKind;
use nalgebra::Vector3;
use toml::de::DeTable;

use crate::contact::{Coefficient, Friction};
use crate::material::Material;
use crate::model::shape::Shape;
use crate::model::{Amplitude, Motion, Rotation};
use crate::statics::{NewtonSettings, TimeSettings};

pub use control::{Colour, Output};
pub use error::{DeckError, Problem};
pub use interface::{Contact, Interface};
pub use resolve::Sides;

use reader::{Section, Source};

/// A problem to solve.
#[derive(Clone, Debug, PartialEq)]
pub struct Deck {
    /// The file, for messages; `deck` if the text came from elsewhere.
    pub path: PathBuf,
    /// What the problem is called; empty if it was not given.
    pub title: String,
    /// The element of every interface.
    pub contact: Contact,
    /// Materials by name.
    pub materials: BTreeMap<String, Material>,
    /// Parts in the order of the text.
    pub parts: Vec<PartEntry>,
    /// Where nodes are held or moved.
    pub boundaries: Vec<Boundary>,
    /// Pressures on surfaces.
    pub pressures: Vec<Pressure>,
    /// Surfaces that may touch.
    pub interfaces: Vec<Interface>,
    /// How time goes on.
    pub time: TimeSettings,
    /// When an increment is solved.
    pub newton: NewtonSettings,
    /// What is written.
    pub output: Output,
}

/// A name and where it stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Reference {
    /// `"pipe.inner"`.
    pub name: String,
    /// Line of the deck, from 1.
    pub line: usize,
}

/// A part of the deck.
#[derive(Clone, Debug, PartialEq)]
pub struct PartEntry {
    /// Its name.
    pub name: String,
    /// Line of the deck, from 1.
    pub line: usize,
    /// Where its mesh comes from.
    pub source: PartSource,
    /// Kind of the elements of a solid shape; hexahedra of first order for other parts, where it has no meaning.
    pub element: ElementKind,
    /// Whether its hexahedra with 8 nodes have incompatible modes; `None`: those of a file that it calls so.
    pub incompatible_modes: Option<bool>,
    /// Names of its materials, each with its element set where there are several; none for a rigid part.
    pub materials: Vec<(Option<String>, Reference)>,
    /// Rotations that place it, one after the other.
    pub rotations: Vec<Rotation>,
    /// Translation that places it, after the rotations, length.
    pub translation: [f64; 3],
}

/// Where the mesh of a part comes from. A `file` is relative to the deck; `instance` is one of an Abaqus file, if there are several.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)] // The names say what the fields are.
pub enum PartSource {
    /// A parametric shape.
    Shape(Shape),
    /// Solid elements of a mesh file. `elements` is an element set; `None` for all solid elements.
    Solid { file: PathBuf, instance: Option<String>, elements: Option<String> },
    /// Facets of a mesh file. `surface` is a surface or an element set.
    Rigid { file: PathBuf, instance: Option<String>, surface: String },
}

/// Nodes that are held or moved.
#[derive(Clone, Debug, PartialEq)]
pub struct Boundary {
    /// Line of the deck, from 1.
    pub line: usize,
    /// Node sets; all of their nodes take part.
    pub nodes: Vec<Reference>,
    /// The axes along which they are prescribed: x, y, z.
    pub axes: [bool; 3],
    /// Where they are over time.
    pub motion: Motion,
}

/// A pressure on surfaces of deformable parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Pressure {
    /// Line of the deck, from 1.
    pub line: usize,
    /// The surfaces.
    pub surfaces: Vec<Reference>,
    /// Pressure at amplitude 1, force per area; positive pushes against the surface.
    pub value: f64,
    /// Whether it acts on the deformed surface along its normal; otherwise each force keeps the direction and size it has at
    /// the start.
    pub follower: bool,
    /// Factor over time.
    pub amplitude: Amplitude,
}

impl Deck {
    /// The shape of a part; `None` if there is no such part, or it comes from a file.
    pub fn shape_mut(&mut self, part: &str) -> Option<&mut Shape> {
        let entry = self.parts.iter_mut().find(|entry| entry.name == part)?;
        match &mut entry.source {
            PartSource::Shape(shape) => Some(shape),
            PartSource::Solid { .. } | PartSource::Rigid { .. } => None,
        }
    }

    /// Reads a deck.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, DeckError> {
        let path = path.as_ref();
        let text =
            std::fs::read_to_string(path).map_err(|cause| DeckError::Read { path: path.into(), cause })?;
        Self::parse_named(&text, path)
    }

    /// Reads the text of a deck.
    ///
    /// # Errors
    /// [`DeckError::Invalid`].
    pub fn parse(text: &str) -> Result<Self, DeckError> {
        Self::parse_named(text, "deck")
    }

    /// Reads the text of a deck; `path` is used in messages only.
    ///
    /// # Errors
    /// [`DeckError::Invalid`].
    pub fn parse_named(text: &str, path: impl AsRef<Path>) -> Result<Self, DeckError> {
        let source = Source { text, path: path.as_ref() };
        let (table, errors) = DeTable::parse_recoverable(text);
        // Of several the first: those after it may be its consequences.
        let place = |error: &toml::de::Error| error.span().map_or(0, |span| span.start);
        if let Some(error) = errors.iter().min_by_key(|error| place(error)) {
            return Err(source.error(place(error), Problem::Syntax { message: error.message().into() }));
        }
        if table.get_ref().is_empty() {
            return Err(source.error(0, Problem::Empty));
        }
        let deck = Section::root(source, &table).expect(schema::DECK)?;

        let time = control::time(&deck)?;
        let contact = interface::contact(&deck)?;
        let interface = |section| interface::interface(section, contact);
        let mut materials = BTreeMap::new();
        for (name, material) in named(&deck, "materials")? {
            materials.insert(name, parts::material(&material)?);
        }
        let parts = named(&deck, "parts")?;
        let made = Self {
            path: source.path.to_path_buf(),
            title: deck.get("title").map_or_else(|| Ok(String::new()), |title| title.text())?,
            contact,
            materials,
            parts: parts.iter().map(|(name, part)| parts::part(name, part)).collect::<Result<_, _>>()?,
            boundaries: listed(&deck, "boundary", |section| conditions::boundary(section, time.end))?,
            pressures: listed(&deck, "pressure", |section| conditions::pressure(section, time.end))?,
            interfaces: interface::distinct(source, listed(&deck, "interface", interface)?)?,
            newton: control::newton(&deck)?,
            output: control::output(&deck)?,
            time,
        };
        control::check_operator(&deck, &made.newton, &made.interfaces)?;
        made.check_turns()?;
        Ok(made)
    }
}

impl Deck {
    /// Whether no boundary turns so far in an increment, against what stands still or one that it rubs on, that friction takes it for a turn
    /// the other way, or for none.
    fn check_turns(&self) -> Result<(), DeckError> {
        const MOST: f64 = 180.0;
        let rubs = |friction: &Friction| friction.coefficient != Coefficient::Constant(0.0);
        let rubbing: Vec<&Interface> = self
            .interfaces
            .iter()
            .filter(|interface| interface.friction.as_ref().is_some_and(rubs))
            .collect();
        if rubbing.is_empty() {
            return Ok(());
        }
        let turning: Vec<Turning<'_>> = self.boundaries.iter().filter_map(Turning::new).collect();
        // Increments end at the points of amplitudes.
        let points = turning.iter().flat_map(|turning| turning.amplitude.times());
        let inner = points.filter(|&time| 0.0 < time && time < self.time.end);
        let mut times: Vec<f64> = [0.0].into_iter().chain(inner).chain([self.time.end]).collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        // A factor that is not 0 at the start is a jump.
        let first = self.time.increment.min(times[1]);
        let check = |increment: f64, factor: &dyn Fn(&Amplitude) -> f64| {
            for (k, own) in turning.iter().enumerate() {
                let turn = own.degrees * factor(own.amplitude);
                let others = turning[..k].iter().filter(|other| {
                    rubbing.iter().any(|interface| own.boundary.turns_against(other.boundary, interface))
                });
                let relative = others.filter_map(|other| {
                    Some(turn - own.axis_along(other)? * other.degrees * factor(other.amplitude))
                });
                let degrees = relative.map(f64::abs).fold(turn.abs(), f64::max);
                if !(degrees < MOST) {
                    let problem = Box::new(Problem::TurnsTooFar { degrees, increment });
                    let line = own.boundary.line;
                    return Err(DeckError::Invalid { path: self.path.clone(), line, problem });
                }
            }
            Ok(())
        };
        check(first, &|amplitude| amplitude.at(first))?;
        for pair in times.windows(2) {
            let (start, end) = (pair[0], pair[1]);
            let increment = self.time.maximum.min(end - start);
            check(increment, &|amplitude| {
                (amplitude.at(end) - amplitude.at(start)) * (increment / (end - start))
            })?;
        }
        Ok(())
    }
}

/// A boundary that turns.
struct Turning<'a> {
    boundary: &'a Boundary,
    axis: Vector3<f64>,
    degrees: f64,
    amplitude: &'a Amplitude,
}

impl<'a> Turning<'a> {
    fn new(boundary: &'a Boundary) -> Option<Self> {
        let (rotation, amplitude) = boundary.motion.rotation.as_ref()?;
        Some(Self {
            boundary,
            axis: Vector3::from(rotation.axis).normalize(),
            degrees: rotation.degrees,
            amplitude,
        })
    }

    /// 1 if the other turns about an axis of the same direction, −1 of the opposite one; else no angle between them is beyond 180°.
    fn axis_along(&self, other: &Self) -> Option<f64> {
        const PARALLEL: f64 = 1e-6;
        (self.axis.cross(&other.axis).norm() < PARALLEL).then(|| self.axis.dot(&other.axis).signum())
    }
}

impl Boundary {
    /// Whether the two are of parts on the two sides of an interface.
    fn turns_against(&self, other: &Self, interface: &Interface) -> bool {
        let part = |reference: &Reference| reference.name.split('.').next().map(str::to_owned);
        let on = |boundary: &Self, side: &[Reference]| {
            boundary.nodes.iter().any(|nodes| side.iter().any(|own| part(own) == part(nodes)))
        };
        let [master, slave] = [&interface.master, &interface.slave];
        on(self, master) && on(other, slave) || on(self, slave) && on(other, master)
    }
}

/// The tables of a table of tables, such as `[parts.pipe]`.
fn named<'a>(deck: &Section<'a>, field: &str) -> Result<Vec<(String, Section<'a>)>, DeckError> {
    let Some(tables) = deck.get(field) else { return Ok(Vec::new()) };
    tables.section()?.all().into_iter().map(|(name, table)| Ok((name, table.section()?))).collect()
}

/// What `read` makes of each of the tables of a list, such as `[[boundary]]`.
fn listed<'a, T>(
    deck: &Section<'a>,
    field: &str,
    read: impl Fn(Section<'a>) -> Result<T, DeckError>,
) -> Result<Vec<T>, DeckError> {
    let Some(tables) = deck.get(field) else { return Ok(Vec::new()) };
    let expected = format!("a list of tables: write [[{field}]]");
    tables.list(&expected)?.iter().map(|table| read(table.section()?)).collect()
}
