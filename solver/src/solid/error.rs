//! Why there is no solid, or no answer.

use crate::material::{MaterialError, Unresolved};
use diffuse_contact_mesh::names::shown;

/// What an element is called where it comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ElementName {
    /// The part.
    pub part: String,
    /// Its place in the part, from 1.
    pub number: usize,
    /// Its number in the mesh file, if the part is from one.
    pub label: Option<u64>,
}

/// Everything that can be wrong with elements and positions. Indices of elements count from 0 through all bodies, and those of points from
/// 0; messages count from 1, elements within their part, or give an element's number in the mesh file. `name` is what an element is called;
/// it is `None` before that is known.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum SolidError {
    /// There is no such material.
    #[error("the material of body {body}: {source}")]
    Material { body: usize, source: MaterialError },
    #[error("{} has node {node}, but there are {count} nodes", called(*element, name))]
    NodeOutOfRange { element: usize, name: Option<Box<ElementName>>, node: usize, count: usize },
    /// The element has no volume around a point, or its nodes are in the wrong order. `jacobian` is volume per volume of the reference
    /// cube, length³.
    #[error(
        "{} has the Jacobian {jacobian:e} at integration point {}: it must be positive", called(*element, name), point + 1
    )]
    BadElement { element: usize, name: Option<Box<ElementName>>, point: usize, jacobian: f64 },
    /// A position is NaN or infinite.
    #[error("node {node} is at {position:?}")]
    NotFinite { node: usize, position: [f64; 3] },
    #[error("{given} {what} given, {expected} expected")]
    WrongCount { what: &'static str, given: usize, expected: usize },
    /// Material is turned inside out. A smaller step may avoid it.
    #[error("{} is turned inside out: det F = {jacobian:e} at integration point {}", called(*element, name), point + 1)]
    Inverted { element: usize, name: Option<Box<ElementName>>, point: usize, jacobian: f64 },
    /// The incompatible modes of an element find no equilibrium that is stable, as under a pressure of several times the shear modulus. A
    /// smaller step may avoid it.
    #[error(
        "the incompatible modes of {} find no stable equilibrium: take elements without them where strains or pressures are this large",
        called(*element, name)
    )]
    UnstableModes { element: usize, name: Option<Box<ElementName>> },
    /// Material is deformed beyond what floating point resolves. A smaller step may avoid it.
    #[error("{} at integration point {}: {source}", called(*element, name), point + 1)]
    Unresolved { element: usize, name: Option<Box<ElementName>>, point: usize, source: Unresolved },
}

/// An element in a message.
fn called(element: usize, name: &Option<Box<ElementName>>) -> String {
    match name.as_deref() {
        None => format!("element {}", element + 1),
        Some(ElementName { part, number, label: None }) => {
            format!("element {number} of the part {:?}", shown(part))
        }
        Some(ElementName { part, label: Some(label), .. }) => {
            format!("element {label} of the mesh file (part {:?})", shown(part))
        }
    }
}

impl SolidError {
    /// The same with the name of the element, if it is about one; `of` gives that of an index.
    pub(super) fn named(mut self, of: impl FnOnce(usize) -> ElementName) -> Self {
        if let Some((element, name)) = self.element_mut() {
            *name = Some(Box::new(of(element)));
        }
        self
    }

    fn element_mut(&mut self) -> Option<(usize, &mut Option<Box<ElementName>>)> {
        match self {
            Self::NodeOutOfRange { element, name, .. }
            | Self::BadElement { element, name, .. }
            | Self::Inverted { element, name, .. }
            | Self::UnstableModes { element, name }
            | Self::Unresolved { element, name, .. } => Some((*element, name)),
            Self::Material { .. } | Self::NotFinite { .. } | Self::WrongCount { .. } => None,
        }
    }
}

pub(super) fn check_finite(positions: &[[f64; 3]]) -> Result<(), SolidError> {
    match positions.iter().position(|position| !position.iter().all(|x| x.is_finite())) {
        Some(node) => Err(SolidError::NotFinite { node, position: positions[node] }),
        None => Ok(()),
    }
}

pub(super) fn check_count(what: &'static str, given: usize, expected: usize) -> Result<(), SolidError> {
    match given == expected {
        true => Ok(()),
        false => Err(SolidError::WrongCount { what, given, expected }),
    }
}
