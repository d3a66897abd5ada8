//! What derivatives of an element are written to.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::fixed::Argument;
use crate::kernel::{Differentiated, ElementSpec, Mode, Returned, Role, Signature};

/// An argument that derivatives are written to.
#[derive(Clone, Debug)]
pub(super) struct Derivative {
    pub name: String,
    entries: Entries,
}

#[derive(Clone, Copy, Debug)]
enum Entries {
    /// One for each variable.
    Gradient,
    /// A packed lower triangle.
    Hessian,
    /// Of a quantity with so many entries, a row for each.
    Jacobian(usize),
    /// Of a Hessian with a vector: one for each variable.
    HessianProduct,
    /// Of a Jacobian with a vector: one for each entry of the quantity.
    JacobianProduct(usize),
}

/// The argument with the vector of a product.
pub(super) const DIRECTION: &str = "direction";

impl Derivative {
    /// Those of a kernel.
    pub fn of(spec: &ElementSpec) -> Vec<Self> {
        match spec.direction {
            Some(_) => Self::products(&spec.signature),
            None => Self::all(&spec.signature, spec.mode),
        }
    }

    /// Products of derivatives with a vector.
    pub fn products(signature: &Signature) -> Vec<Self> {
        let product = |value: &Returned| {
            let entries = match value.differentiated {
                Differentiated::Twice => Entries::HessianProduct,
                _ => Entries::JacobianProduct(value.dimensions.iter().product()),
            };
            Some(Self { name: value.product()?, entries })
        };
        signature.values.iter().filter_map(product).collect()
    }

    /// Those of a mode.
    pub fn all(signature: &Signature, mode: Mode) -> Vec<Self> {
        let mut all = Vec::new();
        let mut add = |name: &str, entries| all.push(Self { name: name.to_owned(), entries });
        for value in signature.values.iter().filter(|_| mode > Mode::Value) {
            match value.differentiated {
                Differentiated::Twice => {
                    add("gradient", Entries::Gradient);
                    if mode == Mode::Hessian {
                        add("hessian", Entries::Hessian);
                    }
                }
                Differentiated::Once => {
                    let rows = value.dimensions.iter().product();
                    add(&format!("{}_jacobian", value.name), Entries::Jacobian(rows));
                }
                Differentiated::Not => {}
            }
        }
        all
    }

    /// Row and column of an entry by variables of the element, if it stands in a later row than the first: rows of a Jacobian are as long
    /// as the element has variables, with those of its nodes.
    pub fn later_row(&self, k: usize, of_element: usize) -> Option<[usize; 2]> {
        let is_later = matches!(self.entries, Entries::Jacobian(_)) && k >= of_element;
        is_later.then(|| [k / of_element, k % of_element])
    }

    /// The names of those of a kernel.
    pub fn names(spec: &ElementSpec) -> Vec<String> {
        Self::of(spec).into_iter().map(|derivative| derivative.name).collect()
    }

    pub fn ident(&self) -> Ident {
        format_ident!("{}", self.name)
    }

    /// Number of entries, for so many variables.
    pub const fn length(&self, variables: usize) -> usize {
        match self.entries {
            Entries::Gradient | Entries::HessianProduct => variables,
            Entries::Hessian => variables * (variables + 1) / 2,
            Entries::Jacobian(rows) => rows * variables,
            Entries::JacobianProduct(rows) => rows,
        }
    }

    /// The same for `count` nodes.
    pub fn length_by_count(&self) -> TokenStream {
        match self.entries {
            Entries::Gradient | Entries::HessianProduct => quote!(variables(count)),
            Entries::Hessian => quote!(packed_row(variables(count))),
            Entries::Jacobian(rows) => quote!(#rows * variables(count)),
            Entries::JacobianProduct(rows) => quote!(#rows),
        }
    }

    /// The mode from which on there is one.
    pub fn least_mode(&self) -> TokenStream {
        match self.entries {
            Entries::Hessian => quote!(Mode::Hessian),
            Entries::Gradient | Entries::Jacobian(_) => quote!(Mode::Gradient),
            Entries::HessianProduct | Entries::JacobianProduct(_) => quote!(Mode::Value),
        }
    }

    /// What it holds, for the documentation.
    pub fn meaning(&self, signature: &Signature) -> String {
        let variables: Vec<String> = signature
            .inputs
            .iter()
            .chain(&signature.nodes)
            .filter(|input| input.role == Role::Variable)
            .map(|input| format!("`{}`", input.name))
            .collect();
        let by = variables.join(", ");
        let by =
            if signature.nodes.is_empty() { by } else { format!("{by}, those of the nodes node by node") };
        let twice = signature.values.iter().find(|value| value.differentiated == Differentiated::Twice);
        let function = twice.map_or("", |value| value.name.as_str());
        match self.entries {
            Entries::Gradient => format!("∂{function}/∂x, x: {by}"),
            Entries::Hessian => format!("∂²{function}/∂x∂x, packed lower triangle, row by row, x: {by}"),
            Entries::Jacobian(_) => {
                let of = self.name.trim_end_matches("_jacobian");
                format!("∂{of}/∂x, a row per entry, x: {by}")
            }
            Entries::HessianProduct => format!("∂²{function}/∂x∂x v, x: {by}"),
            Entries::JacobianProduct(_) => {
                let of = self.name.trim_end_matches("_jacobian_product");
                format!("∂{of}/∂x v, x: {by}")
            }
        }
    }
}

/// What derivatives of a mode are written to, of an element of fixed size.
pub(super) fn arguments(signature: &Signature, mode: Mode) -> Vec<Argument> {
    sized(Derivative::all(signature, mode), signature)
}

/// The same of a kernel.
pub(super) fn arguments_of(spec: &ElementSpec) -> Vec<Argument> {
    sized(Derivative::of(spec), &spec.signature)
}

fn sized(derivatives: Vec<Derivative>, signature: &Signature) -> Vec<Argument> {
    let count = signature.variables();
    let argument = |derivative: Derivative| {
        let length = derivative.length(count);
        (derivative.name, length)
    };
    derivatives.into_iter().map(argument).collect()
}
