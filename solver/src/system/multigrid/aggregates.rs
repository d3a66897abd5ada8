//! Nodes grouped into the nodes of a coarser level.

use super::sparse::View;

/// A link is strong if its block is at least this part of the largest one of either of its nodes.
const STRONG: f64 = 0.05;
/// Belongs to no aggregate.
pub const NONE: u32 = u32::MAX;

/// Which nodes are neighbours, in compressed rows. Nodes of two bodies never are, whatever the matrix says: a common aggregate could
/// not slide along itself.
#[derive(Clone, Copy, Debug)]
pub struct Links<'a> {
    /// Where the row of each node begins, and the end.
    pub starts: &'a [usize],
    /// The neighbours of each node, the node itself among them.
    pub columns: &'a [u32],
}

/// Links that own their lists.
#[derive(Clone, Debug, Default)]
pub struct OwnLinks {
    starts: Vec<usize>,
    columns: Vec<u32>,
}

impl OwnLinks {
    /// To be read.
    pub fn view(&self) -> Links<'_> {
        Links { starts: &self.starts, columns: &self.columns }
    }
}

/// The aggregate of each node.
#[derive(Clone, Debug)]
pub struct Aggregates {
    /// By node; [`NONE`] for one without unknowns.
    pub of: Vec<u32>,
    /// How many there are.
    pub count: usize,
}

impl<'a> Links<'a> {
    fn row(&self, node: usize) -> &'a [u32] {
        &self.columns[self.starts[node]..self.starts[node + 1]]
    }

    /// The links of aggregates: those with linked nodes.
    pub fn of(&self, aggregates: &Aggregates) -> OwnLinks {
        let mut members = vec![Vec::new(); aggregates.count];
        for (node, &aggregate) in aggregates.of.iter().enumerate() {
            if aggregate != NONE {
                members[aggregate as usize].push(node);
            }
        }
        let mut links = OwnLinks { starts: vec![0], columns: Vec::new() };
        let mut own = Vec::new();
        for nodes in members {
            own.clear();
            let neighbours = nodes.iter().flat_map(|&node| self.row(node));
            own.extend(neighbours.map(|&node| aggregates.of[node as usize]).filter(|&other| other != NONE));
            own.sort_unstable();
            own.dedup();
            links.columns.extend_from_slice(&own);
            links.starts.push(links.columns.len());
        }
        links
    }
}

impl Aggregates {
    /// Groups of a node and its strong neighbours, as many as fit side by side; what is left joins one of them. `is_active`: whether a
    /// node has unknowns.
    pub fn new<const N: usize>(matrix: View<'_, N, N>, links: Links<'_>, is_active: &[bool]) -> Self {
        let strong = strong_links(matrix, links, is_active);
        let strong = strong.view();
        let nodes = matrix.height();
        let mut of = vec![NONE; nodes];
        let mut count = 0;
        let free = |node: usize, of: &[u32]| is_active[node] && of[node] == NONE;
        for node in (0..nodes).filter(|&node| is_active[node]) {
            let row = strong.row(node);
            if row.len() > 1 && row.iter().all(|&other| free(other as usize, &of)) {
                row.iter().for_each(|&other| of[other as usize] = count);
                count += 1;
            }
        }
        // The others join the neighbours' most frequent aggregate, as those are without one another.
        let before = of.clone();
        for node in (0..nodes).filter(|&node| is_active[node]) {
            if before[node] == NONE {
                of[node] = most_frequent(strong.row(node).iter().map(|&other| before[other as usize]));
            }
        }
        for node in 0..nodes {
            if free(node, &of) {
                for &other in strong.row(node) {
                    if of[other as usize] == NONE {
                        of[other as usize] = count;
                    }
                }
                of[node] = count;
                count += 1;
            }
        }
        Self { of, count: count as usize }
    }
}

/// The aggregate named most often, the least of several; [`NONE`] without any.
fn most_frequent(names: impl Iterator<Item = u32>) -> u32 {
    let mut names: Vec<u32> = names.filter(|&name| name != NONE).collect();
    names.sort_unstable();
    let (mut best, mut most) = (NONE, 0);
    for run in names.chunk_by(|a, b| a == b) {
        if run.len() > most {
            (best, most) = (run[0], run.len());
        }
    }
    best
}

/// Links over blocks that are not small, with the node itself.
fn strong_links<const N: usize>(matrix: View<'_, N, N>, links: Links<'_>, is_active: &[bool]) -> OwnLinks {
    let size = |block: &[[f64; N]; N]| block.as_flattened().iter().map(|x| x * x).sum::<f64>();
    let nodes = matrix.height();
    let linked = |node: usize| {
        let own = links.row(node).iter().map(|&other| other as usize);
        own.filter(move |&other| is_active[other] && other != node)
    };
    let square = |node: usize, other: usize| matrix.block(node, other).map_or(0.0, size);
    let largest: Vec<f64> =
        (0..nodes).map(|node| linked(node).map(|other| square(node, other)).fold(0.0, f64::max)).collect();
    let mut strong = OwnLinks { starts: vec![0], columns: Vec::new() };
    for node in 0..nodes {
        let mut has_itself = false;
        for &other in links.row(node) {
            let other = other as usize;
            let bound = STRONG * STRONG * largest[node].min(largest[other]);
            let is_strong = is_active[node] && is_active[other] && square(node, other) >= bound;
            if other == node || is_strong {
                has_itself |= other == node;
                strong.columns.push(other as u32);
            }
        }
        if !has_itself {
            strong.columns.push(node as u32);
        }
        strong.starts.push(strong.columns.len());
    }
    strong
}
