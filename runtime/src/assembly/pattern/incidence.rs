//! Which nodes belong to which elements, and which nodes meet.

use std::ops::Range;

use rayon::prelude::*;

use super::super::{AssemblyError, Elements, reserve};
use crate::interface::Pool;

/// Nodes whose neighbours are sought in one go.
const CHUNK: usize = 1024;
/// In place of a node where there is none.
pub const NO_NODE: u32 = u32::MAX;

/// Lists of numbers one after another: those of k are `numbers[offsets[k]..offsets[k + 1]]`.
#[derive(Clone, Debug)]
pub struct Lists<T> {
    offsets: Vec<usize>,
    numbers: Vec<T>,
}

impl<T> Lists<T> {
    pub fn len(&self) -> usize {
        self.offsets.len() - 1
    }

    pub fn range(&self, k: usize) -> Range<usize> {
        self.offsets[k]..self.offsets[k + 1]
    }

    pub fn get(&self, k: usize) -> &[T] {
        &self.numbers[self.range(k)]
    }

    /// Bytes.
    pub fn memory(&self) -> usize {
        size_of_val(self.offsets.as_slice()) + size_of_val(self.numbers.as_slice())
    }
}

/// Lists one after another, and where each ends.
type Ends = (Vec<u32>, Vec<usize>);

/// A node in an element.
#[derive(Clone, Copy, Debug)]
pub struct Occurrence {
    pub element: u32,
    /// Place among the element's nodes, 0 for the slave.
    pub local: u32,
}

/// The nodes of each element, slave first; nodes are below `nodes`.
pub fn element_nodes<E: Elements + ?Sized>(elements: &E, nodes: usize) -> Result<Lists<u32>, AssemblyError> {
    for (what, count) in [("nodes", nodes), ("elements", elements.len())] {
        if count >= NO_NODE as usize {
            return Err(AssemblyError::TooLarge { what, count });
        }
    }
    let mut offsets = reserve("elements", elements.len() + 1)?;
    let mut count = 0_usize;
    for k in 0..elements.len() {
        offsets.push(count);
        count = count.saturating_add(elements.element(k).node_count());
    }
    offsets.push(count);
    let mut numbers = reserve("nodes of elements", count)?;
    for k in 0..elements.len() {
        for node in elements.element(k).nodes() {
            if node >= nodes {
                return Err(AssemblyError::UnknownNode { element: k, node, nodes });
            }
            numbers.push(node as u32);
        }
    }
    Ok(Lists { offsets, numbers })
}

/// Where each node occurs, in order of the elements.
pub fn occurrences(of_elements: &Lists<u32>, nodes: usize) -> Result<Lists<Occurrence>, AssemblyError> {
    let mut offsets = reserve("nodes", nodes + 1)?;
    offsets.resize(nodes + 1, 0_usize);
    for &node in &of_elements.numbers {
        offsets[node as usize] += 1;
    }
    let mut sum = 0;
    for offset in &mut offsets {
        sum += std::mem::replace(offset, sum);
    }
    let mut numbers = reserve("nodes of elements", sum)?;
    numbers.resize(sum, Occurrence { element: 0, local: 0 });
    for k in 0..of_elements.len() {
        for (local, &node) in of_elements.get(k).iter().enumerate() {
            let next = &mut offsets[node as usize];
            numbers[*next] = Occurrence { element: k as u32, local: local as u32 };
            *next += 1;
        }
    }
    // Each offset has moved on to where the next one began.
    offsets.rotate_right(1);
    offsets[0] = 0;
    Ok(Lists { offsets, numbers })
}

/// The nodes that occur together with each node, itself among them, ascending.
pub fn neighbours(
    of_elements: &Lists<u32>,
    occurrences: &Lists<Occurrence>,
) -> Result<Lists<u32>, AssemblyError> {
    let nodes = occurrences.len();
    let pool = Pool::default();
    let chunks: Vec<Result<Ends, AssemblyError>> = (0..nodes.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let range = chunk * CHUNK..nodes.min((chunk + 1) * CHUNK);
            // A node is marked by the last one whose neighbour it was found to be.
            pool.with(|| vec![NO_NODE; nodes], |marks| together(of_elements, occurrences, range, marks))
        })
        .collect();
    let chunks = chunks.into_iter().collect::<Result<Vec<_>, _>>()?;
    let count = chunks.iter().map(|(numbers, _)| numbers.len()).sum();
    let mut numbers = reserve("pairs of nodes", count)?;
    let mut offsets = reserve("nodes", nodes + 1)?;
    offsets.push(0);
    for (more, ends) in chunks {
        let base = numbers.len();
        numbers.extend(more);
        offsets.extend(ends.into_iter().map(|end| base + end));
    }
    Ok(Lists { offsets, numbers })
}

/// The neighbours of consecutive nodes, one list after another, and where each ends.
fn together(
    of_elements: &Lists<u32>,
    occurrences: &Lists<Occurrence>,
    range: Range<usize>,
    marks: &mut [u32],
) -> Result<Ends, AssemblyError> {
    let (mut numbers, mut ends) = (Vec::new(), Vec::with_capacity(range.len()));
    for node in range {
        let (start, mut last) = (numbers.len(), None);
        for occurrence in occurrences.get(node) {
            // A node that occurs twice in an element has the same neighbours there.
            if last.replace(occurrence.element) == Some(occurrence.element) {
                continue;
            }
            let others = of_elements.get(occurrence.element as usize);
            let too_large =
                |_| AssemblyError::TooLarge { what: "pairs of nodes", count: start + others.len() };
            numbers.try_reserve(others.len()).map_err(too_large)?;
            for &other in others {
                if std::mem::replace(&mut marks[other as usize], node as u32) != node as u32 {
                    numbers.push(other);
                }
            }
        }
        numbers[start..].sort_unstable();
        ends.push(numbers.len());
    }
    Ok((numbers, ends))
}
