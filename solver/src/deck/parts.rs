//! `[materials.…]` and `[parts.…]`.

use std::path::PathBuf;

use diffuse_contact_mesh::ElementKind;

use super::error::{DeckError, Problem};
use super::reader::{Field, Section};
use super::{PartEntry, PartSource, Reference, schema};
use crate::material::{Material, MaterialModel, Plasticity};
use crate::model::shape::{
    Axis, Ball, Block, Cylinder, Facets, HalfSpace, KINDS, Pipe, RigidCylinder, RigidPlane, RigidSphere,
    RigidTorus, RigidWave, Shape, Side, Strip, StripPiece,
};
use crate::model::{Rotation, ShapeError};

/// Bounds of a modulus, as lengths have them: squares of stresses stay far from overflow.
const MODULI: [f64; 2] = [1e-50, 1e50];

fn modulus(field: &Field) -> Result<f64, DeckError> {
    field.number_in("positive (1e-50 to 1e50)", |value| (MODULI[0]..=MODULI[1]).contains(&value))
}

pub(super) fn material(section: &Section) -> Result<Material, DeckError> {
    let section = section.clone().expect(schema::MATERIAL)?;
    let poisson = section.need("poisson")?;
    let models = [("hencky", true), ("neo-hooke", false)];
    let is_hencky = section.or("model", true, |model| model.word(&models))?;
    let model = if is_hencky {
        MaterialModel::Hencky { plasticity: plasticity(&section)? }
    } else {
        section.refuse(&["yield_stress", "hardening"], "for model = \"neo-hooke\", which is elastic")?;
        MaterialModel::NeoHooke
    };
    Ok(Material {
        young: modulus(&section.need("young")?)?,
        poisson: poisson.number_in("above -1 and below 0.5", |value| value > -1.0 && value < 0.5)?,
        model,
    })
}

fn plasticity(section: &Section) -> Result<Option<Plasticity>, DeckError> {
    let Some(yield_stress) = section.get("yield_stress") else {
        section.refuse(&["hardening"], "without yield_stress")?;
        return Ok(None);
    };
    let yield_stress = modulus(&yield_stress)?;
    let hardening = section.or("hardening", 0.0, |field| {
        field.number_in("at least 0 and at most 1e50", |value| (0.0..=MODULI[1]).contains(&value))
    })?;
    Ok(Some(Plasticity { yield_stress, hardening }))
}

pub(super) fn part(name: &str, section: &Section) -> Result<PartEntry, DeckError> {
    let invalid = crate::model::ModelError::InvalidName { part: name.into() };
    if name.is_empty() || name.contains('.') {
        return Err(section.error(Problem::Part { part: name.into(), error: invalid }));
    }
    let source = source(name, section)?;
    let rigid = match &source {
        PartSource::Shape(shape) => shape.is_rigid(),
        PartSource::Solid { .. } => false,
        PartSource::Rigid { .. } => true,
    };
    let materials = if rigid {
        section.refuse(&["material"], "for a rigid part")?;
        Vec::new()
    } else {
        of_sets(&section.need("material")?)?
    };
    let rotations = match section.get("rotate") {
        Some(field) if field.is_list() => {
            field.list("rotations")?.iter().map(placed).collect::<Result<_, _>>()?
        }
        Some(field) => vec![placed(&field)?],
        None => Vec::new(),
    };
    let translation = section.or("translate", [0.0; 3], Field::vector)?;
    let (element, incompatible_modes) = match (&source, section.get("element")) {
        (PartSource::Shape(_), Some(field)) => {
            let (element, incompatible_modes) = shape_element(&field)?;
            (element, Some(incompatible_modes))
        }
        (_, Some(field)) => {
            (ElementKind::Hexahedron8, Some(field.word(&[("hex8", false), ("hex8i", true)])?))
        }
        _ => (ElementKind::Hexahedron8, None),
    };
    Ok(PartEntry {
        name: name.into(),
        line: section.line(),
        source,
        element,
        incompatible_modes,
        materials,
        rotations,
        translation,
    })
}

/// One material, or a table with one for each element set.
fn of_sets(field: &Field) -> Result<Vec<(Option<String>, Reference)>, DeckError> {
    let named = |field: &Field| Ok(Reference { name: field.text()?, line: field.line() });
    if !field.is_table() {
        return Ok(vec![(None, named(field)?)]);
    }
    field.section()?.all().iter().map(|(set, field)| Ok((Some(set.clone()), named(field)?))).collect()
}

/// The kind of a shape's elements, and whether they have incompatible modes.
fn shape_element(field: &Field) -> Result<(ElementKind, bool), DeckError> {
    let modes = [("hex8i", (ElementKind::Hexahedron8, true))];
    let words: Vec<_> = KINDS.map(|(name, kind)| (name, (kind, false))).into_iter().chain(modes).collect();
    field.word(&words)
}

/// A rotation that places a part.
fn placed(field: &Field) -> Result<Rotation, DeckError> {
    rotation(&field.section()?.expect(schema::ROTATION)?)
}

/// Axis, point and angle.
pub(super) fn rotation(section: &Section) -> Result<Rotation, DeckError> {
    let field = section.need("axis")?;
    let axis = field.vector()?;
    if axis.iter().all(|&x| x == 0.0) {
        return Err(field.out_of_range("a direction: at least one component other than 0", 0.0));
    }
    let point = section.or("point", [0.0; 3], Field::vector)?;
    Ok(Rotation { axis, point, degrees: section.need("degrees")?.number()? })
}

fn from_file(section: &Section, file: &Field) -> Result<PartSource, DeckError> {
    let known: Vec<&str> = schema::PART.iter().chain(schema::FILE).copied().collect();
    let section = section.clone().expect(&known)?;
    let file = PathBuf::from(file.text()?);
    let instance = section.get("instance").map(|field| field.text()).transpose()?;
    match section.get("surface") {
        Some(surface) => {
            section.refuse(&["elements", "element"], "beside surface, which makes a rigid part")?;
            Ok(PartSource::Rigid { file, instance, surface: surface.text()? })
        }
        None => {
            let elements = section.get("elements").map(|field| field.text()).transpose()?;
            Ok(PartSource::Solid { file, instance, elements })
        }
    }
}

fn shaped(part: &str, section: &Section, shape: &Field) -> Result<PartSource, DeckError> {
    let words: Vec<(&str, usize)> =
        schema::SHAPES.iter().enumerate().map(|(k, (name, _))| (*name, k)).collect();
    let (name, fields) = schema::SHAPES[shape.word(&words)?];
    // `file` belongs to PART, but not beside a shape.
    let own = if name.starts_with("rigid") { &[] } else { schema::SOLID_SHAPE };
    let known: Vec<&str> =
        schema::PART.iter().chain(fields).chain(own).copied().filter(|&field| field != "file").collect();
    let section = section.clone().expect(&known)?;
    let shape = read_shape(name, &ShapeSection(section.clone()))?;
    let mut steps = shape.clone();
    let element = section.get("element").map(|field| shape_element(&field)).transpose()?;
    if element.is_some_and(|(kind, _)| kind.has_middles()) {
        // As many nodes as cells of half the size have.
        steps.divisions_mut().iter_mut().for_each(|count| *count = count.saturating_mul(2));
    }
    shape.check().and_then(|()| steps.check()).map_err(|error| {
        let problem = Problem::Shape { part: part.into(), error: error.clone() };
        let field = match error {
            ShapeError::OutOfRange { field, .. } => field,
            ShapeError::TooManyNodes { .. } | ShapeError::NoMemory { .. } => "divisions",
        };
        match section.get(field) {
            Some(field) => field.error(problem),
            None => section.error(problem),
        }
    })?;
    Ok(PartSource::Shape(shape))
}

/// What the part is made of.
fn source(name: &str, section: &Section) -> Result<PartSource, DeckError> {
    match (section.get("shape"), section.get("file")) {
        (Some(shape), None) => shaped(name, section, &shape),
        (None, Some(file)) => from_file(section, &file),
        (Some(shape), Some(_)) => {
            let field = shape.name().into();
            Err(shape.error(Problem::Meaningless { field, reason: "beside file" }))
        }
        (None, None) => {
            // A misspelt field comes before a missing one.
            let every = schema::SHAPES.iter().flat_map(|(_, fields)| fields.iter());
            let own = schema::FILE.iter().chain(schema::SOLID_SHAPE);
            let known: Vec<&str> = schema::PART.iter().chain(own).chain(every).copied().collect();
            section.clone().expect(&known)?;
            Err(section.incomplete("either a shape or a file"))
        }
    }
}

fn read_shape(name: &str, section: &ShapeSection) -> Result<Shape, DeckError> {
    Ok(match name {
        "pipe" => Shape::Pipe(Pipe {
            axis: section.axis()?,
            inner_radius: section.number("inner_radius")?,
            outer_radius: section.number("outer_radius")?,
            angles: section.angles("angles")?,
            length: section.number("length")?,
            divisions: section.counts("divisions")?,
            grading: section.gradings()?,
        }),
        "cylinder" => Shape::Cylinder(Cylinder {
            axis: section.axis()?,
            radius: section.number("radius")?,
            length: section.number("length")?,
            keep: section.keep()?,
            divisions: section.counts("divisions")?,
            core: section.number_or("core", 0.5)?,
            grading: section.gradings()?,
            layer_grading: section.number_or("layer_grading", 1.0)?,
        }),
        "sphere" => Shape::Ball(Ball {
            radius: section.number("radius")?,
            keep: section.keep()?,
            divisions: section.counts("divisions")?,
            core: section.number_or("core", 0.5)?,
            grading: section.gradings()?,
            layer_grading: section.number_or("layer_grading", 1.0)?,
        }),
        "strip" => Shape::Strip(Strip {
            path: section.path()?,
            thickness: section.number("thickness")?,
            width: section.number("width")?,
            divisions: section.counts("divisions")?,
        }),
        "rigid-plane" => Shape::RigidPlane(RigidPlane {
            size: section.0.need("size")?.numbers("a list of two numbers")?,
            divisions: section.counts("divisions")?,
            facets: section.facets()?,
        }),
        "rigid-wave" => Shape::RigidWave(RigidWave {
            size: section.0.need("size")?.numbers("a list of two numbers")?,
            height: section.number("height")?,
            wavelength: section.number("wavelength")?,
            divisions: section.counts("divisions")?,
            facets: section.facets()?,
        }),
        "rigid-cylinder" => Shape::RigidCylinder(RigidCylinder {
            axis: section.axis()?,
            radius: section.number("radius")?,
            angles: section.angles("angles")?,
            length: section.number("length")?,
            divisions: section.counts("divisions")?,
            facets: section.facets()?,
            side: section.side()?,
        }),
        "rigid-sphere" => Shape::RigidSphere(RigidSphere {
            radius: section.number("radius")?,
            keep: section.keep()?,
            divisions: section.0.need("divisions")?.count()?,
            grading: section.gradings()?,
            facets: section.facets()?,
            side: section.side()?,
        }),
        "rigid-torus" => Shape::RigidTorus(RigidTorus {
            axis: section.axis()?,
            radius: section.number("radius")?,
            tube_radius: section.number("tube_radius")?,
            angles: section.angles("angles")?,
            tube_angles: section.angles("tube_angles")?,
            divisions: section.counts("divisions")?,
            facets: section.facets()?,
            side: section.side()?,
        }),
        // "box" and "plate"
        _ => Shape::Block(Block {
            origin: section.0.or("origin", [0.0; 3], Field::vector)?,
            size: section.0.need("size")?.vector()?,
            divisions: section.counts("divisions")?,
            grading: section.gradings()?,
        }),
    })
}

/// A piece of a strip's path: straight with a length, or an arc with radius and angle.
fn piece(field: &Field) -> Result<StripPiece, DeckError> {
    let section = field.section()?.expect(schema::PIECE)?;
    let rise = section.or("rise", 0.0, Field::number)?;
    let piece = match section.get("length") {
        Some(length) => {
            section.refuse(&["radius", "degrees"], "beside length")?;
            StripPiece::straight(length.positive()?)
        }
        None => {
            let (radius, degrees) = (section.need("radius")?.positive()?, section.need("degrees")?);
            let angle = degrees.number()?;
            if angle == 0.0 {
                return Err(degrees.out_of_range("other than 0", angle));
            }
            StripPiece::arc(radius, angle)
        }
    };
    Ok(piece.with_rise(rise))
}

/// What the shapes have in common. Ranges are the shapes' own business.
struct ShapeSection<'a>(Section<'a>);

impl ShapeSection<'_> {
    fn number(&self, field: &'static str) -> Result<f64, DeckError> {
        self.0.need(field)?.number()
    }

    fn number_or(&self, field: &str, default: f64) -> Result<f64, DeckError> {
        self.0.or(field, default, Field::number)
    }

    fn counts<const N: usize>(&self, field: &'static str) -> Result<[usize; N], DeckError> {
        let expected = if N == 2 { "a list of two whole numbers" } else { "a list of three whole numbers" };
        self.0.need(field)?.counts(expected)
    }

    fn gradings(&self) -> Result<[f64; 3], DeckError> {
        self.0.or("grading", [1.0; 3], Field::vector)
    }

    fn angles(&self, field: &str) -> Result<[f64; 2], DeckError> {
        self.0.or(field, [0.0, 360.0], |field| field.numbers("a list of two angles"))
    }

    fn axis(&self) -> Result<Axis, DeckError> {
        let words = [Axis::X, Axis::Y, Axis::Z].map(|axis| (axis.name(), axis));
        self.0.or("axis", Axis::Z, |field| field.word(&words))
    }

    fn keep(&self) -> Result<Vec<HalfSpace>, DeckError> {
        let Some(keep) = self.0.get("keep") else { return Ok(Vec::new()) };
        let words = HalfSpace::ALL.map(|half| (half.name(), half));
        keep.list("a list of half spaces like \"x+\"")?.iter().map(|field| field.word(&words)).collect()
    }

    fn path(&self) -> Result<Vec<StripPiece>, DeckError> {
        self.0.need("path")?.list("a list of pieces")?.iter().map(piece).collect()
    }

    fn facets(&self) -> Result<Facets, DeckError> {
        let words = [("quadrilaterals", Facets::Quadrilaterals), ("triangles", Facets::Triangles)];
        self.0.or("facets", Facets::default(), |field| field.word(&words))
    }

    fn side(&self) -> Result<Side, DeckError> {
        let words = [("outside", Side::Outside), ("inside", Side::Inside)];
        self.0.or("side", Side::default(), |field| field.word(&words))
    }
}
