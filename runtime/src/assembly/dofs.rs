//! Which equation a degree of freedom has.

use super::AssemblyError;

/// The equation numbers of the nodes' three displacements.
///
/// A degree of freedom without equation is constrained: what the elements contribute to it is left out.
///
/// ```
/// use diffuse_contact::assembly::DofMap;
///
/// // All of them, in order of the nodes.
/// assert_eq!(DofMap::standard(4).equation(2, 1), Some(7));
/// // Node 0 is held; the others are numbered consecutively.
/// let held = DofMap::numbering(4, |node, _axis| node != 0)?;
/// assert_eq!((held.equation(0, 1), held.equation(2, 1)), (None, Some(4)));
/// // The equations a solver has given them.
/// let solver = DofMap::new(100, [[Some(30), Some(31), None], [Some(7), Some(8), Some(9)]])?;
/// assert_eq!((solver.nodes(), solver.equations()), (2, 100));
/// # Ok::<(), diffuse_contact::assembly::AssemblyError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DofMap {
    nodes: usize,
    equations: usize,
    /// Equations of each node or [`NONE`]; `None` for 3·node + axis.
    numbers: Option<Vec<[usize; 3]>>,
}

/// In place of an equation where there is none.
const NONE: usize = usize::MAX;

impl DofMap {
    /// Equation 3·node + axis for each of `nodes` nodes (at most `usize::MAX / 3`).
    pub fn standard(nodes: usize) -> Self {
        let nodes = nodes.min(usize::MAX / 3);
        Self { nodes, equations: 3 * nodes, numbers: None }
    }

    /// Numbers the degrees of freedom for which `is_free(node, axis)` holds consecutively, in order of nodes and axes.
    ///
    /// # Errors
    /// [`AssemblyError::TooLarge`].
    pub fn numbering(
        nodes: usize,
        mut is_free: impl FnMut(usize, usize) -> bool,
    ) -> Result<Self, AssemblyError> {
        let mut numbers = super::reserve("nodes", nodes)?;
        let mut equations = 0;
        for node in 0..nodes {
            numbers.push([0, 1, 2].map(|axis| {
                let free = is_free(node, axis);
                let number = if free { equations } else { NONE };
                equations += usize::from(free);
                number
            }));
        }
        Ok(Self { nodes, equations, numbers: Some(numbers) })
    }

    /// Three consecutive equations per node, given the first one of each; `None` for a node without equations. The
    /// system has `equations` in all.
    ///
    /// # Errors
    /// [`AssemblyError::UnknownEquation`], [`AssemblyError::SharedEquation`].
    pub fn from_first(
        equations: usize,
        first: impl IntoIterator<Item = Option<usize>>,
    ) -> Result<Self, AssemblyError> {
        // An equation beyond usize is beyond `equations`, too, and refused with the largest number there is.
        let three = |first: usize| [0, 1, 2].map(|axis| Some(first.saturating_add(axis)));
        Self::new(equations, first.into_iter().map(|first| first.map_or([None; 3], three)))
    }

    /// The given equations for the x, y and z axis of each node, `None` where it is constrained. The system has
    /// `equations` in all; some of them may belong to none of these nodes.
    ///
    /// # Errors
    /// [`AssemblyError::UnknownEquation`] if a number is not below `equations`,
    /// [`AssemblyError::SharedEquation`] if a number occurs twice, [`AssemblyError::TooLarge`].
    pub fn new(
        equations: usize,
        numbers: impl IntoIterator<Item = [Option<usize>; 3]>,
    ) -> Result<Self, AssemblyError> {
        let given = numbers.into_iter();
        let mut numbers: Vec<[usize; 3]> = super::reserve("nodes", given.size_hint().0)?;
        for (node, own) in given.enumerate() {
            for (axis, equation) in own.into_iter().enumerate() {
                if let Some(equation) = equation
                    && equation >= equations
                {
                    return Err(AssemblyError::UnknownEquation { node, axis, equation, equations });
                }
            }
            numbers.push(own.map(|equation| equation.unwrap_or(NONE)));
        }
        let free = || numbers.iter().flatten().copied().filter(|&equation| equation != NONE);
        let mut sorted: Vec<usize> = super::reserve("equations", free().count())?;
        sorted.extend(free());
        sorted.sort_unstable();
        if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(AssemblyError::SharedEquation { equation: pair[0] });
        }
        Ok(Self { nodes: numbers.len(), equations, numbers: Some(numbers) })
    }

    /// Number of nodes.
    pub const fn nodes(&self) -> usize {
        self.nodes
    }

    /// Number of equations: rows of the forces and of the tangent.
    pub const fn equations(&self) -> usize {
        self.equations
    }

    /// The equation of a degree of freedom, `None` if it is constrained.
    ///
    /// # Panics
    /// If there is no such node or `axis` is above 2.
    pub fn equation(&self, node: usize, axis: usize) -> Option<usize> {
        assert!(node < self.nodes && axis < 3, "axis {axis} of node {node} of {}", self.nodes);
        match &self.numbers {
            Some(numbers) => Some(numbers[node][axis]).filter(|&equation| equation != NONE),
            None => Some(3 * node + axis),
        }
    }

    /// The first equation of a node that has three in a row, x before y before z.
    pub(super) fn three_in_a_row(&self, node: usize) -> Option<usize> {
        let Some(numbers) = &self.numbers else { return Some(3 * node) };
        let [x, y, z] = numbers[node];
        (x != NONE && y == x.wrapping_add(1) && z == x.wrapping_add(2) && z != NONE).then_some(x)
    }

    /// The number of a node's equations.
    pub(super) fn count(&self, node: usize) -> usize {
        self.numbers.as_ref().map_or(3, |numbers| numbers[node].iter().filter(|&&own| own != NONE).count())
    }

    /// The equations of a node's axes.
    pub(super) fn of_node(&self, node: usize) -> [Option<usize>; 3] {
        [0, 1, 2].map(|axis| self.equation(node, axis))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_first_equation_stands_for_three() {
        let map = DofMap::from_first(12, [Some(9), None, Some(0)]).unwrap();
        assert_eq!(map.of_node(0), [Some(9), Some(10), Some(11)]);
        assert_eq!(map.of_node(1), [None; 3]);
        assert_eq!((map.nodes(), map.equations(), map.equation(2, 2)), (3, 12, Some(2)));
    }

    #[test]
    fn impossible_numbers_are_refused() {
        let error = DofMap::from_first(5, [Some(0), Some(3)]).unwrap_err();
        assert_eq!(error, AssemblyError::UnknownEquation { node: 1, axis: 2, equation: 5, equations: 5 });
        let error = DofMap::from_first(usize::MAX, [Some(usize::MAX - 1)]).unwrap_err();
        assert_eq!(error.code(), "unknown-equation");
        let error = DofMap::from_first(9, [Some(0), Some(2)]).unwrap_err();
        assert_eq!(error, AssemblyError::SharedEquation { equation: 2 });
    }

    #[test]
    fn constrained_degrees_of_freedom_are_skipped() {
        let map = DofMap::numbering(3, |node, axis| node != 1 || axis == 2).unwrap();
        assert_eq!(map.of_node(1), [None, None, Some(3)]);
        assert_eq!(map.of_node(2), [Some(4), Some(5), Some(6)]);
        assert_eq!(map.equations(), 7);
    }
}
