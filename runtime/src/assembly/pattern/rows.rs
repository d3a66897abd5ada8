//! Rows of a matrix by the nodes they belong to, and the columns of the union pattern.

use super::super::{AssemblyError, DofMap, in_memory, reserve};
use super::incidence::{NO_NODE, Neighbours};
use super::split::for_each_part;

/// Consecutive rows of the same node: all three of them, unless the map of degrees of freedom tears them apart.
#[derive(Clone, Copy, Debug)]
pub struct RowGroup {
    /// The first of the rows.
    pub first: usize,
    pub node: u32,
    /// Axes of the rows.
    pub axes: [u8; 3],
    /// Number of rows.
    pub count: u8,
}

impl RowGroup {
    pub fn axes(&self) -> &[u8] {
        &self.axes[..usize::from(self.count)]
    }
}

/// The rows of nodes that have neighbours, ascending.
pub fn row_groups(neighbours: &Neighbours, dofs: &DofMap) -> Result<Vec<RowGroup>, AssemblyError> {
    let equations = dofs.equations();
    let mut owners = reserve("equations", equations)?;
    owners.resize(equations, (NO_NODE, 0_u8));
    for node in (0..dofs.nodes()).filter(|&node| !neighbours.get(node).is_empty()) {
        for (axis, equation) in dofs.of_node(node).into_iter().enumerate() {
            if let Some(equation) = equation {
                owners[equation] = (node as u32, axis as u8);
            }
        }
    }
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

/// Row offsets and columns of the union pattern, in memory that may be there.
pub fn union(
    neighbours: &Neighbours,
    groups: &[RowGroup],
    dofs: &DofMap,
    (row_offsets, columns): (Vec<usize>, Vec<u32>),
) -> Result<(Vec<usize>, Vec<u32>), AssemblyError> {
    let equations = dofs.equations();
    if u32::try_from(equations).is_err() {
        return Err(AssemblyError::TooLarge { what: "equations", count: equations });
    }
    let mut row_offsets = in_memory("equations", equations + 1, row_offsets)?;
    row_offsets.fill(0);
    for group in groups {
        let around = neighbours.get(group.node as usize).iter();
        let length = around.map(|&node| dofs.count(node as usize)).sum();
        row_offsets[group.first..][..usize::from(group.count)].fill(length);
    }
    let mut sum = 0_usize;
    for offset in &mut row_offsets {
        sum = sum.saturating_add(std::mem::replace(offset, sum));
    }
    let mut columns = in_memory("entries", sum, columns)?;
    let start = |k: usize| groups.get(k).map_or(sum, |group| row_offsets[group.first]);
    for_each_part(0..groups.len(), &start, &mut columns, &|range, columns: &mut [u32]| {
        let mut rest = columns;
        for k in range {
            let (own, after) = rest.split_at_mut(start(k + 1) - start(k));
            of_group(&groups[k], neighbours, dofs, own);
            rest = after;
        }
    });
    Ok((row_offsets, columns))
}

/// The columns of a group's rows.
fn of_group(group: &RowGroup, neighbours: &Neighbours, dofs: &DofMap, columns: &mut [u32]) {
    let (row, others) = columns.split_at_mut(columns.len() / usize::from(group.count));
    let mut rest = &mut *row;
    for &node in neighbours.get(group.node as usize) {
        let node = node as usize;
        let (own, after) = rest.split_at_mut(dofs.count(node));
        if let Some(first) = dofs.three_in_a_row(node) {
            own.iter_mut().zip(first..).for_each(|(column, equation)| *column = equation as u32);
        } else {
            let equations = dofs.of_node(node).into_iter().flatten();
            own.iter_mut().zip(equations).for_each(|(column, equation)| *column = equation as u32);
        }
        rest = after;
    }
    if !row.is_sorted() {
        row.sort_unstable();
    }
    others.chunks_exact_mut(row.len().max(1)).for_each(|other| other.copy_from_slice(row));
}
