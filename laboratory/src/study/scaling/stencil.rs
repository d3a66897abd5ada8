//! What a facet and a slave need around them, asked of the library on a small surface: on a regular one it is the same everywhere.

use std::collections::BTreeSet;

use diffuse_contact::interface::InterfaceOptions;
use diffuse_contact::{Mode, Point};

use super::super::patch::Patch;
use super::super::{StudyError, paired};
use super::rects::{Rect, joined};

/// Where slaves are in their cells: exact in binary, so that boxes are.
pub const SHIFT: [f64; 2] = [0.375, 0.406_25];
/// Cells along a side of the small surface, and the one that is asked about.
const SIDE: usize = 24;
const MIDDLE: i64 = 12;

/// By offset from a cell.
#[derive(Debug)]
pub struct Stencil {
    /// Facets that a window has for a facet of its core.
    pub facets: Vec<Rect>,
    /// Nodes listed at a facet.
    pub listed: u64,
    /// Nodes that carry the fit of a slave in the cell.
    pub masters: Vec<Rect>,
    /// How many those are.
    pub carried: u64,
    /// Master nodes that a master node is coupled with where every cell has a slave, itself included.
    pub coupled: u64,
}

impl Stencil {
    pub fn new() -> Result<Self, StudyError> {
        let Patch { positions, facets } = Patch::new([SIDE; 2], |x, y| [x, y, 0.0]);
        let slave: Point = [MIDDLE as f64 + SHIFT[0], MIDDLE as f64 + SHIFT[1], 0.0];
        let (mut interface, _) = paired(positions, facets, [slave], InterfaceOptions::default())?;
        let window = interface.window(&[[slave, slave]], 0.0)?;
        let (integers, _) = window.to_numbers();
        let place =
            |number: u64, stride: u64| [number % stride, number / stride].map(|place| place as i64 - MIDDLE);
        let stride = SIDE as u64 + 1;
        let contacts = interface.evaluate(Mode::Gradient)?;
        let masters: Vec<[i64; 2]> =
            contacts.get(0).nodes.iter().map(|&node| place(u64::from(node), stride)).collect();
        let coupled: BTreeSet<[i64; 2]> =
            masters.iter().flat_map(|a| masters.iter().map(|b| [b[0] - a[0], b[1] - a[1]])).collect();
        Ok(Self {
            facets: rectangles(window.facets().map(|facet| place(facet, SIDE as u64))),
            // The last number of the header.
            listed: integers[9] as u64,
            carried: masters.len() as u64,
            coupled: coupled.len() as u64,
            masters: rectangles(masters),
        })
    }
}

/// Cells as few rectangles.
fn rectangles(cells: impl IntoIterator<Item = [i64; 2]>) -> Vec<Rect> {
    joined(cells.into_iter().map(Rect::cell).collect())
}
