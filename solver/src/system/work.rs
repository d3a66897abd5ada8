//! How much work the factors of a matrix take.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

use super::{BlockPattern, Equations};

/// About how many multiplications the symmetric factors of the free equations take for an entry of their matrix, from an ordering of the
/// nodes; infinite where there is no memory for that.
pub(super) fn multiplications_per_entry(pattern: &BlockPattern, equations: &Equations) -> f64 {
    let mut numbers = vec![u32::MAX; pattern.nodes()];
    let mut nodes = Vec::new();
    for node in 0..pattern.nodes() {
        if (0..3).any(|axis| equations.number(node, axis).is_some()) {
            numbers[node] = nodes.len() as u32;
            nodes.push(node);
        }
    }
    let (mut starts, mut rows) = (vec![0_u32], Vec::new());
    for &node in &nodes {
        rows.extend(
            pattern.row(node).iter().map(|&row| numbers[row as usize]).filter(|&row| row != u32::MAX),
        );
        let Ok(end) = u32::try_from(rows.len()) else { return f64::INFINITY };
        starts.push(end);
    }
    let size = nodes.len();
    let Ok(mut buffer) = MemBuffer::try_new(amd::order_scratch::<u32>(size, rows.len())) else {
        return f64::INFINITY;
    };
    let (mut order, mut inverse) = (vec![0; size], vec![0; size]);
    let graph = SymbolicSparseColMatRef::new_checked(size, size, &starts, None, &rows);
    let stack = MemStack::new(&mut buffer);
    let Ok(work) = amd::order(&mut order, &mut inverse, graph, amd::Control::default(), stack) else {
        return f64::INFINITY;
    };
    // Each pair of nodes has a block.
    let axes = equations.len() as f64 / size.max(1) as f64;
    work.n_mult_subs_ldl * axes / rows.len().max(1) as f64
}
