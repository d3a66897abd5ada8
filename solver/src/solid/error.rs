//! Why there is no solid, or no answer.

use crate::material::{MaterialError, Unresolved};

/// Everything that can be wrong with elements and positions. Elements count through all bodies.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolidError {
    /// There is no such material.
    #[error("the material of body {body}: {source}")]
    Material {
        /// Index of the body.
        body: usize,
        /// The constant.
        source: MaterialError,
    },
    /// An element names a node that does not exist.
    #[error("element {element} has node {node}, but there are {count} nodes")]
    NodeOutOfRange {
        /// Index of the element.
        element: usize,
        /// The node.
        node: usize,
        /// Number of nodes.
        count: usize,
    },
    /// The element has no volume around a point, or its nodes are in the wrong order.
    #[error(
        "element {element} has the Jacobian {jacobian:e} at integration point {point}: it must be positive"
    )]
    BadElement {
        /// Index of the element.
        element: usize,
        /// Index of the point, 0 to 7.
        point: usize,
        /// Volume per volume of the reference cube, length³.
        jacobian: f64,
    },
    /// A position is NaN or infinite.
    #[error("node {node} is at {position:?}")]
    NotFinite {
        /// The node.
        node: usize,
        /// Its position.
        position: [f64; 3],
    },
    /// A list does not fit.
    #[error("{given} {what} given, {expected} expected")]
    WrongCount {
        /// `"positions"` or `"states"`.
        what: &'static str,
        /// How many there are.
        given: usize,
        /// How many there should be.
        expected: usize,
    },
    /// Material is turned inside out. A smaller step may avoid it.
    #[error("element {element} is turned inside out: det F = {jacobian:e} at integration point {point}")]
    Inverted {
        /// Index of the element.
        element: usize,
        /// Index of the point, 0 to 7.
        point: usize,
        /// det F.
        jacobian: f64,
    },
    /// Material is deformed beyond what floating point resolves. A smaller step may avoid it.
    #[error("element {element} at integration point {point}: {source}")]
    Unresolved {
        /// Index of the element.
        element: usize,
        /// Index of the point, 0 to 7.
        point: usize,
        /// The stretches.
        source: Unresolved,
    },
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
