//! Finding the places of all entries.

use rayon::prelude::*;

use super::super::{AssemblyError, DofMap, Elements, reserve};
use super::split::for_each_part;
use super::{CsrPattern, NO_SLOT, Occurrence, RowGroup};

/// Nodes whose neighbours are sought in one go.
const CHUNK: usize = 1024;
/// In place of a node where there is none.
const NO_NODE: u32 = u32::MAX;

impl CsrPattern {
    /// The union of the places of all paired elements. Elements without masters take part in nothing, but count.
    ///
    /// # Errors
    /// [`AssemblyError::UnknownNode`]; [`AssemblyError::TooLarge`] if there are 2³² nodes or elements or more, or
    /// an array cannot be allocated. (Where the system promises more memory than it has, it may still end the
    /// program when the memory is used.)
    pub fn union<E: Elements + ?Sized>(elements: &E, dofs: &DofMap) -> Result<Self, AssemblyError> {
        for (what, count) in [("nodes", dofs.nodes()), ("elements", elements.len())] {
            if count >= NO_NODE as usize {
                return Err(AssemblyError::TooLarge { what, count });
            }
        }
        let mut pattern = Self::with_elements(elements, dofs.nodes())?;
        pattern.find_occurrences(dofs.nodes())?;
        let neighbours = pattern.find_neighbours(dofs.nodes())?;
        pattern.find_pairs(&neighbours)?;
        pattern.find_slots(&neighbours, dofs)?;
        pattern.find_rows(&neighbours, dofs)?;
        Ok(pattern)
    }

    /// The elements' nodes, and how many pairs they have.
    fn with_elements<E: Elements + ?Sized>(elements: &E, nodes: usize) -> Result<Self, AssemblyError> {
        let mut node_offsets = reserve("elements", elements.len() + 1)?;
        let mut pair_offsets = reserve("elements", elements.len() + 1)?;
        let (mut node_count, mut pair_count) = (0_usize, 0_usize);
        for k in 0..elements.len() {
            node_offsets.push(node_count);
            pair_offsets.push(pair_count);
            let count = elements.element(k).node_count();
            node_count = node_count.saturating_add(count);
            pair_count = pair_count.saturating_add(count.saturating_mul(count));
        }
        node_offsets.push(node_count);
        pair_offsets.push(pair_count);
        let mut element_nodes = reserve("nodes of elements", node_count)?;
        let mut pairs = reserve("pairs of nodes", pair_count)?;
        for k in 0..elements.len() {
            for node in elements.element(k).nodes() {
                if node >= nodes {
                    return Err(AssemblyError::UnknownNode { element: k, node, nodes });
                }
                element_nodes.push(node as u32);
            }
        }
        pairs.resize(pair_count, 0);
        Ok(Self {
            row_offsets: Vec::new(),
            columns: Vec::new(),
            node_offsets,
            element_nodes,
            pair_offsets,
            pairs,
            occurrence_offsets: Vec::new(),
            occurrences: Vec::new(),
            slot_offsets: Vec::new(),
            slots: Vec::new(),
            groups: Vec::new(),
        })
    }

    /// Where each node occurs, in order of the elements.
    fn find_occurrences(&mut self, nodes: usize) -> Result<(), AssemblyError> {
        let mut offsets = reserve("nodes", nodes + 1)?;
        offsets.resize(nodes + 1, 0_usize);
        for &node in &self.element_nodes {
            offsets[node as usize] += 1;
        }
        let mut sum = 0;
        for offset in &mut offsets {
            sum += std::mem::replace(offset, sum);
        }
        let mut occurrences = reserve("nodes of elements", sum)?;
        occurrences.resize(sum, Occurrence { element: 0, local: 0 });
        for k in 0..self.node_offsets.len() - 1 {
            for (local, &node) in self.nodes_of(k).iter().enumerate() {
                let next = &mut offsets[node as usize];
                occurrences[*next] = Occurrence { element: k as u32, local: local as u32 };
                *next += 1;
            }
        }
        // Each offset has moved on to where the next one began.
        offsets.rotate_right(1);
        offsets[0] = 0;
        self.occurrence_offsets = offsets;
        self.occurrences = occurrences;
        Ok(())
    }

    /// The nodes that occur together with each node, itself among them, ascending; those of node i from
    /// `slot_offsets[i]` on.
    fn find_neighbours(&mut self, nodes: usize) -> Result<Vec<u32>, AssemblyError> {
        let chunks: Vec<(Vec<u32>, Vec<usize>)> = (0..nodes.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let (mut neighbours, mut counts, mut together) = (Vec::new(), Vec::new(), Vec::new());
                for node in chunk * CHUNK..nodes.min((chunk + 1) * CHUNK) {
                    self.gather_neighbours(node, &mut together);
                    neighbours.extend_from_slice(&together);
                    counts.push(together.len());
                }
                (neighbours, counts)
            })
            .collect();
        let count = chunks.iter().map(|(neighbours, _)| neighbours.len()).sum();
        let mut neighbours = reserve("pairs of nodes", count)?;
        let mut offsets = reserve("nodes", nodes + 1)?;
        let mut sum = 0;
        for (more, counts) in chunks {
            neighbours.extend(more);
            for count in counts {
                offsets.push(sum);
                sum += count;
            }
        }
        offsets.push(sum);
        self.slot_offsets = offsets;
        Ok(neighbours)
    }

    fn gather_neighbours(&self, node: usize, together: &mut Vec<u32>) {
        together.clear();
        let mut last = None;
        for occurrence in self.occurrences_of(node) {
            // A node that occurs twice in an element has the same neighbours there.
            if last.replace(occurrence.element) != Some(occurrence.element) {
                together.extend_from_slice(self.nodes_of(occurrence.element as usize));
            }
        }
        together.sort_unstable();
        together.dedup();
    }

    /// For the pairs of each element, which of the first node's neighbours the second one is.
    fn find_pairs(&mut self, neighbours: &[u32]) -> Result<(), AssemblyError> {
        let mut pairs = std::mem::take(&mut self.pairs);
        let start = |k: usize| self.pair_offsets[k];
        for_each_part(0..self.pair_offsets.len() - 1, &start, &mut pairs, &|k, pairs: &mut [u32]| {
            let nodes = self.nodes_of(k);
            for (row, &first) in pairs.chunks_exact_mut(nodes.len().max(1)).zip(nodes) {
                let around = &neighbours[self.slot_range(first as usize)];
                for (pair, second) in row.iter_mut().zip(nodes) {
                    *pair = around.partition_point(|node| node < second) as u32;
                }
            }
        });
        self.pairs = pairs;
        Ok(())
    }

    /// The pairs of a node.
    fn slot_range(&self, node: usize) -> std::ops::Range<usize> {
        self.slot_offsets[node]..self.slot_offsets[node + 1]
    }

    /// For each pair of nodes, the places of the second one's columns in a row of the first one.
    fn find_slots(&mut self, neighbours: &[u32], dofs: &DofMap) -> Result<(), AssemblyError> {
        let longest = (0..dofs.nodes()).map(|node| self.slot_range(node).len()).max().unwrap_or(0);
        if longest.saturating_mul(3) >= NO_SLOT as usize {
            return Err(AssemblyError::TooLarge {
                what: "entries of a row",
                count: longest.saturating_mul(3),
            });
        }
        let mut slots = reserve("pairs of nodes", neighbours.len())?;
        slots.resize(neighbours.len(), [NO_SLOT; 3]);
        let start = |node: usize| self.slot_offsets[node];
        for_each_part(0..dofs.nodes(), &start, &mut slots, &|node, slots: &mut [[u32; 3]]| {
            let around = &neighbours[self.slot_range(node)];
            let mut columns: Vec<(usize, usize, usize)> = Vec::with_capacity(3 * around.len());
            for (pair, &second) in around.iter().enumerate() {
                let equations = dofs.of_node(second as usize).into_iter().enumerate();
                columns.extend(equations.filter_map(|(axis, equation)| Some((equation?, pair, axis))));
            }
            columns.sort_unstable();
            for (slot, (_, pair, axis)) in columns.into_iter().enumerate() {
                slots[pair][axis] = slot as u32;
            }
        });
        self.slots = slots;
        Ok(())
    }

    /// The rows' lengths and columns.
    fn find_rows(&mut self, neighbours: &[u32], dofs: &DofMap) -> Result<(), AssemblyError> {
        let equations = dofs.equations();
        let row_count = equations.saturating_add(1);
        let mut row_offsets = reserve("equations", row_count)?;
        row_offsets.resize(row_count, 0_usize);
        let mut owners = reserve("equations", equations)?;
        owners.resize(equations, (NO_NODE, 0_u8));
        for node in 0..dofs.nodes() {
            let slots = &self.slots[self.slot_range(node)];
            let length = slots.iter().flatten().filter(|&&slot| slot != NO_SLOT).count();
            for (axis, equation) in dofs.of_node(node).into_iter().enumerate() {
                if let Some(equation) = equation {
                    row_offsets[equation] = length;
                    owners[equation] = (if length > 0 { node as u32 } else { NO_NODE }, axis as u8);
                }
            }
        }
        let mut sum = 0_usize;
        for offset in &mut row_offsets {
            let length = std::mem::replace(offset, sum);
            sum = sum.saturating_add(length);
        }
        let mut columns = reserve("entries", sum)?;
        columns.resize(sum, 0);
        let groups = row_groups(&owners)?;
        let start = |row: usize| row_offsets[row];
        for_each_part(0..equations, &start, &mut columns, &|row, columns: &mut [usize]| {
            if columns.is_empty() {
                return;
            }
            let pairs = self.slot_range(owners[row].0 as usize);
            for (slots, &second) in self.slots[pairs.clone()].iter().zip(&neighbours[pairs]) {
                for (slot, equation) in slots.iter().zip(dofs.of_node(second as usize)) {
                    if let Some(equation) = equation {
                        columns[*slot as usize] = equation;
                    }
                }
            }
        });
        (self.row_offsets, self.columns, self.groups) = (row_offsets, columns, groups);
        Ok(())
    }
}

/// Runs of rows that belong to the same node.
fn row_groups(owners: &[(u32, u8)]) -> Result<Vec<RowGroup>, AssemblyError> {
    let runs = || owners.chunk_by(|(first, _), (second, _)| first == second);
    let mut groups = reserve("nodes", runs().filter(|run| run[0].0 != NO_NODE).count())?;
    let mut first = 0;
    for run in runs() {
        if run[0].0 != NO_NODE {
            let mut axes = [0; 3];
            for (axis, (_, of_row)) in axes.iter_mut().zip(run) {
                *axis = *of_row;
            }
            groups.push(RowGroup { first, node: run[0].0, axes, count: run.len() as u8 });
        }
        first += run.len();
    }
    Ok(groups)
}
