//! What a kernel reads and what it returns.

use crate::expr::{Expr, Matrix, Vector, entry_name};

/// Whether a name is an identifier of Rust that the code may have as it is.
pub(crate) fn is_identifier(name: &str) -> bool {
    // `gen` is a keyword from the edition of 2024 on.
    // Space and comments around a name are none of it.
    let is_whole = syn::parse_str::<proc_macro2::Ident>(name).is_ok_and(|ident| ident == name);
    is_whole && !name.starts_with("r#") && name != "gen"
}

/// Whether a kernel differentiates by an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It does.
    Variable,
    /// It does not.
    Parameter,
}

/// An input: a field of the struct that a kernel reads.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// Field name.
    pub name: String,
    /// What it is, in one line; may be empty.
    pub doc: String,
    /// Whether derivatives are taken by it.
    pub role: Role,
    /// None for a number, `[4, 3]` for four vectors in space.
    pub dimensions: Vec<usize>,
    /// Names of the symbols in the graph, the last dimension fastest.
    pub symbols: Vec<String>,
}

/// Which derivatives of a value are results too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Differentiated {
    /// None.
    Not,
    /// All first ones, as a Jacobian with a row per entry.
    Once,
    /// Gradient and Hessian.
    Twice,
}

/// A value: a field of the struct that a kernel returns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Returned {
    /// Field name.
    pub name: String,
    /// What it is, in one line; may be empty.
    pub doc: String,
    /// As of [`Input`].
    pub dimensions: Vec<usize>,
    /// Its derivatives.
    pub differentiated: Differentiated,
}

impl Returned {
    /// Name of what its derivatives times a vector are written to.
    pub(crate) fn product(&self) -> Option<String> {
        match self.differentiated {
            Differentiated::Not => None,
            Differentiated::Once => Some(format!("{}_jacobian_product", self.name)),
            Differentiated::Twice => Some("hessian_product".to_owned()),
        }
    }
}

/// The vector of a product: names of the symbols of its entries, in the order of the variables they belong to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DirectionSymbols {
    /// By variables of the element.
    pub element: Vec<String>,
    /// By variables of a node.
    pub node: Vec<String>,
}

/// Quadrature points: numbers that differ between them. Outputs are sums over the points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Points {
    /// Names of the symbols in the graph.
    pub symbols: Vec<String>,
    /// Their values, a row per point.
    pub rows: Vec<Vec<f64>>,
}

/// Typed inputs and outputs of a kernel.
#[derive(Clone, Debug, PartialEq)]
pub struct Signature {
    /// Name of the element, that of its module.
    pub name: String,
    /// What it is, in one line; may be empty.
    pub doc: String,
    /// What is read.
    pub inputs: Vec<Input>,
    /// What is read of each node, of a number that is open until a kernel runs; empty for an element of fixed size.
    pub nodes: Vec<Input>,
    /// What is returned.
    pub values: Vec<Returned>,
    /// Points that outputs are summed over; without rows there is no sum.
    pub points: Points,
}

impl Signature {
    /// Number of variables of the element: entries of a gradient, but for those of nodes, which follow.
    pub fn variables(&self) -> usize {
        count_variables(&self.inputs)
    }

    /// Number of variables of a node.
    pub fn node_variables(&self) -> usize {
        count_variables(&self.nodes)
    }
}

fn count_variables(inputs: &[Input]) -> usize {
    inputs.iter().filter(|input| input.role == Role::Variable).map(|input| input.symbols.len()).sum()
}

/// What inputs and outputs can be: a number, a vector, a matrix, or an array of one of these.
pub trait Quantity<'g>: Clone {
    /// Sizes, the outermost first; none for a number.
    fn dimensions() -> Vec<usize>;

    /// The quantity whose entries are made by `entry` from their names, which begin with `name`.
    fn declare(name: &str, entry: &mut dyn FnMut(&str) -> Expr<'g>) -> Self;

    /// The quantity with each entry changed by `change`, which gets the entry's name too.
    #[must_use]
    fn changed(&self, name: &str, change: &mut dyn FnMut(&str, Expr<'g>) -> Expr<'g>) -> Self;

    /// The entries, the last dimension fastest.
    fn entries(&self) -> Vec<Expr<'g>> {
        let mut entries = Vec::new();
        let _ = self.changed("", &mut |_, x| {
            entries.push(x);
            x
        });
        entries
    }
}

impl<'g> Quantity<'g> for Expr<'g> {
    fn dimensions() -> Vec<usize> {
        Vec::new()
    }

    fn declare(name: &str, entry: &mut dyn FnMut(&str) -> Expr<'g>) -> Self {
        entry(name)
    }

    fn changed(&self, name: &str, change: &mut dyn FnMut(&str, Expr<'g>) -> Expr<'g>) -> Self {
        change(name, *self)
    }
}

impl<'g, const N: usize> Quantity<'g> for Vector<'g, N> {
    fn dimensions() -> Vec<usize> {
        vec![N]
    }

    fn declare(name: &str, entry: &mut dyn FnMut(&str) -> Expr<'g>) -> Self {
        Self::from_fn(|k| entry(&entry_name::<N>(name, k)))
    }

    fn changed(&self, name: &str, change: &mut dyn FnMut(&str, Expr<'g>) -> Expr<'g>) -> Self {
        Self::from_fn(|k| change(&entry_name::<N>(name, k), self[k]))
    }
}

impl<'g, const R: usize, const C: usize> Quantity<'g> for Matrix<'g, R, C> {
    fn dimensions() -> Vec<usize> {
        vec![R, C]
    }

    fn declare(name: &str, entry: &mut dyn FnMut(&str) -> Expr<'g>) -> Self {
        Self::from_fn(|row, column| entry(&format!("{name}_{}_{}", row + 1, column + 1)))
    }

    fn changed(&self, name: &str, change: &mut dyn FnMut(&str, Expr<'g>) -> Expr<'g>) -> Self {
        Self::from_fn(|row, column| change(&format!("{name}_{}_{}", row + 1, column + 1), self[row][column]))
    }
}

impl<'g, Q: Quantity<'g>, const N: usize> Quantity<'g> for [Q; N] {
    fn dimensions() -> Vec<usize> {
        [vec![N], Q::dimensions()].concat()
    }

    fn declare(name: &str, entry: &mut dyn FnMut(&str) -> Expr<'g>) -> Self {
        std::array::from_fn(|k| Q::declare(&format!("{name}_{}", k + 1), entry))
    }

    fn changed(&self, name: &str, change: &mut dyn FnMut(&str, Expr<'g>) -> Expr<'g>) -> Self {
        std::array::from_fn(|k| self[k].changed(&format!("{name}_{}", k + 1), change))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expr::{Mat2, Sheet, Vec3};
    use crate::graph::Scope;

    #[test]
    fn entries_are_named_and_ordered_with_the_last_dimension_fastest() {
        let sheet = Sheet::new();
        let mut names = Vec::new();
        let mut entry = |name: &str| {
            names.push(name.to_owned());
            sheet.input(name, Scope::Element)
        };
        let vectors = <[Vec3<'_>; 2]>::declare("x", &mut entry);
        let matrix = Mat2::declare("A", &mut entry);
        let number = Expr::declare("mu", &mut entry);
        assert_eq!(names.join(" "), "x_1_x x_1_y x_1_z x_2_x x_2_y x_2_z A_1_1 A_1_2 A_2_1 A_2_2 mu");
        let of = |entries: Vec<Expr<'_>>| entries.iter().map(|x| x.symbol_name()).collect::<Vec<_>>();
        assert_eq!([of(vectors.entries()), of(matrix.entries()), of(number.entries())].concat(), names);
        assert_eq!(<[Vec3<'_>; 2]>::dimensions(), [2, 3]);
        assert_eq!((Mat2::dimensions(), Expr::dimensions()), (vec![2, 2], Vec::new()));
    }
}
