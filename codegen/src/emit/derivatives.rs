//! What derivatives of an element are written to.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::fixed::Argument;
use crate::model::{Differentiated, Mode, Role, Signature};

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
}

impl Derivative {
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

    /// The names of those of a mode.
    pub fn names(signature: &Signature, mode: Mode) -> Vec<String> {
        Self::all(signature, mode).into_iter().map(|derivative| derivative.name).collect()
    }

    pub fn ident(&self) -> Ident {
        format_ident!("{}", self.name)
    }

    /// Number of entries, for so many variables.
    pub const fn length(&self, variables: usize) -> usize {
        match self.entries {
            Entries::Gradient => variables,
            Entries::Hessian => variables * (variables + 1) / 2,
            Entries::Jacobian(rows) => rows * variables,
        }
    }

    /// The same for `count` nodes.
    pub fn length_by_count(&self) -> TokenStream {
        match self.entries {
            Entries::Gradient => quote!(variables(count)),
            Entries::Hessian => quote!(packed_row(variables(count))),
            Entries::Jacobian(rows) => quote!(#rows * variables(count)),
        }
    }

    /// The mode from which on there is one.
    pub fn least_mode(&self) -> TokenStream {
        match self.entries {
            Entries::Hessian => quote!(Mode::Hessian),
            Entries::Gradient | Entries::Jacobian(_) => quote!(Mode::Gradient),
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
        match self.entries {
            Entries::Gradient => format!("∂energy/∂x, x: {by}"),
            Entries::Hessian => format!("∂²energy/∂x∂x, packed lower triangle, row by row, x: {by}"),
            Entries::Jacobian(_) => {
                let of = self.name.trim_end_matches("_jacobian");
                format!("∂{of}/∂x, a row per entry, x: {by}")
            }
        }
    }
}

/// What derivatives of a mode are written to, of an element of fixed size.
pub(crate) fn arguments(signature: &Signature, mode: Mode) -> Vec<Argument> {
    let count = signature.variables();
    let argument = |derivative: Derivative| {
        let length = derivative.length(count);
        (derivative.name, length)
    };
    Derivative::all(signature, mode).into_iter().map(argument).collect()
}
