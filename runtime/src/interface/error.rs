//! What the caller of an interface has to mend.

use crate::assembly::AssemblyError;
use crate::neighbourhood::NeighbourhoodError;
use crate::surface::{SurfaceError, WindowError};
use crate::{ElementError, Point};

/// Every reason for which an interface cannot be made, paired or evaluated. That a single slave has no contact is none of them, but an
/// [`Outcome`](super::Outcome). A slave's `index` is its place in the list of slaves.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // The messages say what the fields are.
pub enum InterfaceError {
    /// The slave facets are no facets, or a position of the master surface is bad.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// An option of the neighbour search is outside its range.
    #[error(transparent)]
    InvalidSearch(#[from] NeighbourhoodError),
    /// The nodes of the master surface cannot be searched. An index is that of
    /// [`MasterSurface::nodes`](crate::surface::MasterSurface::nodes).
    #[error("the nodes of the master surface: {0}")]
    MasterNodes(#[source] ElementError),
    /// An option is outside its range.
    #[error("the option {name} must be {range}, not {value:?}")]
    InvalidOption { name: &'static str, range: &'static str, value: f64 },
    /// A frame that is held needs masters that are found by another rule than their domains of influence.
    #[error("a frame that is held needs another neighbour rule than \"domains\", such as \"hull-layers\"")]
    HeldFrame,
    /// Symmetry planes need masters that are found by their domains of influence, or facets.
    #[error("symmetry planes need the neighbour rule \"domains\": other rules have no mirror images")]
    NoSymmetry,
    /// Contacts are evaluated, or a step is accepted, before any slave was paired.
    #[error("the slaves have not been paired: call a refresh first")]
    NotRefreshed,
    /// Contact over faces with the diffuse element has nodal domains only: other rules would change the gap in every iteration.
    #[error(
        "contact integrated over faces needs the neighbour rule \"domains\", or the node-to-facet element"
    )]
    FacesNeedDomains,
    /// The numbers of a saved history of friction are none. `place` is that of the first such number.
    #[error("number {place} of the history of friction is none of a history")]
    InvalidHistory { place: usize },
    /// There is not one anchor, or none, for each slave.
    #[error("{found} anchors for {expected} slaves")]
    AnchorCount { found: usize, expected: usize },
    /// An anchor is carried by a node that is none of the master surface, or by an image that it does not have.
    #[error(
        "the anchor of slave {index} is carried by node {node}, which is not on the master surface, or by an image that it does not have"
    )]
    ForeignCarrier { index: usize, node: u32 },
    /// An anchor of a saved history is carried by a node that is not in the window. `node` is its number of the whole.
    #[error(
        "the anchor of slave {index} is carried by node {node}, which is not in the window: its boxes have to hold the anchors of its slaves"
    )]
    CarrierBeyondWindow { index: usize, node: u64 },
    /// The gap that a contact was open by is negative or not finite.
    #[error("the anchor of slave {index} says that it was open by {value:?}")]
    InvalidOpening { index: usize, value: f64 },
    /// The window of a surface is none, or not for these options.
    #[error(transparent)]
    Window(#[from] WindowError),
    /// An option that results in a window depend on is another one than the window was made with. It is the weight, the basis or the
    /// feature angle; over faces also the limit of the distance or the symmetry of the slave.
    #[error("the {what} is not that of the window")]
    OtherThanWindow { what: &'static str },
    /// An interface of a window is asked for what takes the whole surface.
    #[error("{what} takes the whole surface, and this is a window of it")]
    InWindow { what: &'static str },
    /// A surface in contact with itself is asked for what only an interface with slaves of its own has.
    #[error(
        "{what} takes slaves that are no nodes of the surface, and this surface is in contact with itself"
    )]
    SelfContact { what: &'static str },
    /// A law that is none.
    #[error(transparent)]
    Law(#[from] AssemblyError),
    /// More positions or slaves than 32-bit indices can name.
    #[error("{count} {what} are more than 32-bit indices can name")]
    TooMany { what: &'static str, count: usize },
    /// A slave node is not among the positions.
    #[error("slave {index} is node {node}, but there are {count} positions")]
    SlaveOutOfRange { index: usize, node: usize, count: usize },
    /// A node is a slave twice: it would carry twice the force.
    #[error("node {node} is listed as a slave more than once")]
    RepeatedSlave { node: usize },
    /// A node belongs to both surfaces.
    #[error("node {node} is a slave and a node of the master surface")]
    SlaveOnMaster { node: usize },
    /// A slave lies behind a symmetry plane, seen from the master, `distance` from it: its forces would go to mirrored places of the master.
    #[error(
        "slave node {node} lies {distance:e} behind symmetry plane {plane}, seen from the master: both have to lie on one side of it"
    )]
    SlaveBehindSymmetry { node: usize, plane: usize, distance: f64 },
    /// Areas were asked for, but a slave belongs to no slave facet.
    #[error("slave node {node} belongs to no slave facet and so has no tributary area")]
    SlaveWithoutArea { node: usize },
    /// The number of positions is not the one the interface was made with.
    #[error("{found} positions, but the interface was made with {expected}")]
    WrongNumberOfPositions { found: usize, expected: usize },
    /// There are fewer positions than nodes of the window.
    #[error("{found} positions, but the window has {expected} nodes, whose positions come first")]
    FewerThanWindow { found: usize, expected: usize },
    /// There are not as many positions as nodes of the two windows together.
    #[error(
        "{found} positions, but the windows have {master} nodes of the master and {slave} of the slave, {} in all", master + slave
    )]
    OtherThanWindows { found: usize, master: usize, slave: usize },
    /// The results do not fit into memory; [`for_each`](super::ContactInterface::for_each) does not hold them all.
    #[error("no memory for {numbers} numbers of results")]
    OutOfMemory { numbers: usize },
}

impl InterfaceError {
    /// Whether there are as many positions as there were at first.
    pub(crate) fn check_count(positions: &[Point], expected: usize) -> Result<(), Self> {
        let found = positions.len();
        if found == expected { Ok(()) } else { Err(Self::WrongNumberOfPositions { found, expected }) }
    }

    /// Stable machine-readable code.
    pub const fn code(&self) -> &'static str {
        match self {
            Self::Surface(error) => error.code(),
            Self::InvalidSearch(error) => error.code(),
            Self::MasterNodes(error) => error.code(),
            Self::InvalidOption { .. } => "invalid-option",
            Self::HeldFrame => "held-frame",
            Self::NoSymmetry => "no-symmetry",
            Self::NotRefreshed => "not-refreshed",
            Self::FacesNeedDomains => "faces-need-domains",
            Self::InvalidHistory { .. } => "invalid-history",
            Self::AnchorCount { .. } => "anchor-count",
            Self::ForeignCarrier { .. } | Self::CarrierBeyondWindow { .. } => "foreign-carrier",
            Self::InvalidOpening { .. } => "invalid-opening",
            Self::Window(error) => error.code(),
            Self::OtherThanWindow { .. } => "other-than-window",
            Self::InWindow { .. } => "in-window",
            Self::SelfContact { .. } => "self-contact",
            Self::Law(error) => error.code(),
            Self::TooMany { .. } => "too-many",
            Self::SlaveOutOfRange { .. } => "slave-out-of-range",
            Self::RepeatedSlave { .. } => "repeated-slave",
            Self::SlaveOnMaster { .. } => "slave-on-master",
            Self::SlaveBehindSymmetry { .. } => "slave-behind-symmetry",
            Self::SlaveWithoutArea { .. } => "slave-without-area",
            Self::WrongNumberOfPositions { .. }
            | Self::FewerThanWindow { .. }
            | Self::OtherThanWindows { .. } => "wrong-number-of-positions",
            Self::OutOfMemory { .. } => "out-of-memory",
        }
    }
}
