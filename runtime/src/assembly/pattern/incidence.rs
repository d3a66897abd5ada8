//! Which nodes belong to which elements, and which nodes meet.

use std::ops::Range;

use rayon::prelude::*;

use super::super::{AssemblyError, DofMap, Elements, reserve, zeros};
use crate::scratch::Pool;

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

impl<T: Clone + Default> Lists<T> {
    /// So many lists, of numbers that come with the list they belong to, in their order.
    pub fn by(lists: usize, all: impl Iterator<Item = (u32, T)> + Clone) -> Result<Self, AssemblyError> {
        let mut offsets: Vec<usize> = zeros("nodes", lists + 1)?;
        all.clone().for_each(|(list, _)| offsets[list as usize + 1] += 1);
        for k in 0..lists {
            offsets[k + 1] += offsets[k];
        }
        let (mut next, mut numbers) = (offsets.clone(), zeros("nodes", offsets[lists])?);
        for (list, number) in all {
            let place = &mut next[list as usize];
            numbers[*place] = number;
            *place += 1;
        }
        Ok(Self { offsets, numbers })
    }
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

/// The neighbours of consecutive nodes, [`CHUNK`] at a time: the nodes that each occurs together with, itself among them, ascending.
#[derive(Debug)]
pub struct Neighbours(Vec<Lists<u32>>);

impl Neighbours {
    pub fn get(&self, node: usize) -> &[u32] {
        self.0[node / CHUNK].get(node % CHUNK)
    }
}

/// Who occurs where.
#[derive(Debug)]
pub struct Incidence {
    /// Nodes of each element, slave first.
    pub nodes: Lists<u32>,
    /// Which of them begin a run: consecutive numbers and equations. In each row that has one, they lie side by side.
    pub runs: Lists<u32>,
    /// Elements of each node, ascending: as often as it is one of their nodes.
    pub elements: Lists<u32>,
    /// Where the places of the runs begin, for each node of each element.
    pub starts: Vec<usize>,
    /// Where those of each node begin, and after the last node, where they end.
    pub bases: Vec<usize>,
}

/// The nodes of each element, slave first; nodes are below `nodes`.
fn element_nodes<E: Elements + ?Sized>(elements: &E, nodes: usize) -> Result<Lists<u32>, AssemblyError> {
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

/// [`Incidence::runs`].
fn element_runs(nodes: &Lists<u32>, dofs: &DofMap) -> Result<Lists<u32>, AssemblyError> {
    let goes_on = |before: u32, node: u32| {
        let [first, next] = [before, node].map(|node| dofs.three_in_a_row(node as usize));
        before.checked_add(1) == Some(node) && first.is_some_and(|first| next == Some(first + 3))
    };
    let mut offsets = reserve("elements", nodes.len() + 1)?;
    let mut numbers = reserve("nodes of elements", nodes.numbers.len())?;
    offsets.push(0);
    for k in 0..nodes.len() {
        let own = nodes.get(k);
        let begins = |&local: &usize| local == 0 || !goes_on(own[local - 1], own[local]);
        numbers.extend((0..own.len()).filter(begins).map(|local| local as u32));
        offsets.push(numbers.len());
    }
    numbers.shrink_to_fit();
    Ok(Lists { offsets, numbers })
}

impl Incidence {
    pub fn new<E: Elements + ?Sized>(elements: &E, dofs: &DofMap) -> Result<Self, AssemblyError> {
        let nodes = element_nodes(elements, dofs.nodes())?;
        let runs = element_runs(&nodes, dofs)?;
        let mut offsets = zeros("nodes", dofs.nodes() + 1)?;
        let mut bases = zeros("nodes", dofs.nodes() + 1)?;
        for k in 0..nodes.len() {
            let count = runs.range(k).len();
            for &node in nodes.get(k) {
                offsets[node as usize] += 1;
                bases[node as usize] += count;
            }
        }
        for node in (0..dofs.nodes()).filter(|&node| dofs.of_node(node) == [None; 3]) {
            bases[node] = 0;
        }
        let [occurrences, _] = [&mut offsets, &mut bases].map(|counts| {
            let mut sum = 0_usize;
            for count in counts {
                sum += std::mem::replace(count, sum);
            }
            sum
        });
        let mut of_nodes: Vec<u32> = zeros("nodes of elements", occurrences)?;
        let mut starts = reserve("nodes of elements", occurrences)?;
        let (mut next, mut next_start) = (offsets.clone(), bases.clone());
        for k in 0..nodes.len() {
            let count = runs.range(k).len();
            for &node in nodes.get(k) {
                let node = node as usize;
                of_nodes[next[node]] = k as u32;
                next[node] += 1;
                starts.push(next_start[node]);
                next_start[node] += count;
            }
        }
        Ok(Self { nodes, runs, elements: Lists { offsets, numbers: of_nodes }, starts, bases })
    }

    /// The nodes that occur together with each node.
    pub fn neighbours(&self) -> Result<Neighbours, AssemblyError> {
        let nodes = self.elements.len();
        let pool = Pool::default();
        let chunks: Vec<Result<Lists<u32>, AssemblyError>> = (0..nodes.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let range = chunk * CHUNK..nodes.min((chunk + 1) * CHUNK);
                pool.with(
                    || (NodeSet::new(nodes), Vec::new()),
                    |(set, found)| self.together(range, set, found),
                )
            })
            .collect();
        Ok(Neighbours(chunks.into_iter().collect::<Result<_, _>>()?))
    }

    /// The neighbours of consecutive nodes. `found` is memory.
    fn together(
        &self,
        range: Range<usize>,
        set: &mut NodeSet,
        found: &mut Vec<u32>,
    ) -> Result<Lists<u32>, AssemblyError> {
        found.clear();
        let mut offsets = reserve("nodes", range.len() + 1)?;
        offsets.push(0);
        for node in range {
            let mut last = None;
            for &element in self.elements.get(node) {
                // A node that occurs twice in an element has the same neighbours there.
                if last.replace(element) != Some(element) {
                    self.insert(element as usize, set);
                }
            }
            let count = found.len() + set.count();
            let too_large = |_| AssemblyError::TooLarge { what: "pairs of nodes", count };
            found.try_reserve(set.count()).map_err(too_large)?;
            set.take(found);
            offsets.push(found.len());
        }
        let mut numbers = reserve("pairs of nodes", found.len())?;
        numbers.extend_from_slice(found);
        Ok(Lists { offsets, numbers })
    }

    /// Puts the nodes of an element into a set, run by run.
    fn insert(&self, element: usize, set: &mut NodeSet) {
        let (own, runs) = (self.nodes.get(element), self.runs.get(element));
        let ends = runs.iter().skip(1).copied().chain([own.len() as u32]);
        for (&first, end) in runs.iter().zip(ends) {
            set.insert(own[first as usize], end - first);
        }
    }
}

/// A set of nodes, which are given back in ascending order without being sorted one by one.
#[derive(Debug)]
struct NodeSet {
    /// A bit for each node.
    words: Vec<u64>,
    /// Words that are not 0.
    touched: Vec<u32>,
}

impl NodeSet {
    fn new(nodes: usize) -> Self {
        Self { words: vec![0; nodes.div_ceil(64)], touched: Vec::new() }
    }

    /// Inserts consecutive nodes.
    fn insert(&mut self, mut node: u32, mut count: u32) {
        while count > 0 {
            let (place, bit) = (node / 64, node % 64);
            let here = count.min(64 - bit);
            let word = &mut self.words[place as usize];
            if *word == 0 {
                self.touched.push(place);
            }
            *word |= (u64::MAX >> (64 - here)) << bit;
            node += here;
            count -= here;
        }
    }

    fn count(&self) -> usize {
        self.touched.iter().map(|&word| self.words[word as usize].count_ones() as usize).sum()
    }

    /// Moves its nodes to the end of a list.
    fn take(&mut self, numbers: &mut Vec<u32>) {
        self.touched.sort_unstable();
        for word in self.touched.drain(..) {
            let mut bits = std::mem::take(&mut self.words[word as usize]);
            while bits != 0 {
                numbers.push(64 * word + bits.trailing_zeros());
                bits &= bits - 1;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_of_nodes_gives_them_back_ascending_and_is_empty_then() {
        let mut set = NodeSet::new(200);
        for nodes in [vec![199, 3, 64, 3, 63, 128, 0], vec![64], vec![]] {
            nodes.iter().for_each(|&node| set.insert(node, 1));
            let mut expected = nodes;
            expected.sort_unstable();
            expected.dedup();
            assert_eq!(set.count(), expected.len());
            let mut found = Vec::new();
            set.take(&mut found);
            assert_eq!(found, expected);
        }
    }

    #[test]
    fn runs_of_nodes_are_inserted_across_words() {
        let mut set = NodeSet::new(300);
        for (first, count) in [(60, 8), (0, 1), (64, 64), (130, 170), (63, 2), (5, 0)] {
            set.insert(first, count);
            let mut found = Vec::new();
            assert_eq!(set.count(), count as usize);
            set.take(&mut found);
            assert_eq!(found, (first..first + count).collect::<Vec<_>>());
        }
    }
}
