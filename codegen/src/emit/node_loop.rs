//! Loops over the nodes.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::expression::Lanes;
use super::function::FunctionWriter;
use crate::graph::{ExprId, NODE_INDEX};
use crate::schedule::{NodeTarget, Phase};

/// An array of nodes that kernels read, `inputs.name`, with the symbols of what stands in it.
pub(super) struct NodeArray<'a> {
    pub name: &'static str,
    pub symbols: Vec<&'a str>,
    /// What stands in the place of `inputs.name[index]`, if it is another array.
    pub entry: Option<TokenStream>,
    /// The pattern of an entry, from the identifiers of the symbols that are read.
    #[expect(clippy::type_complexity, reason = "a pattern by the names in it")]
    pub pattern: Box<dyn Fn(&dyn Fn(&str) -> Option<Ident>) -> TokenStream + 'a>,
}

/// Results of a loop, with their values.
pub(super) type Outputs = [(NodeTarget, Vec<ExprId>)];

impl<S> FunctionWriter<'_, S> {
    /// A segment and the loop over the nodes that follows. The number of nodes is that of the first array. `outputs` writes the results of
    /// the loop, if it has any.
    pub fn phase(
        &mut self,
        index: usize,
        arrays: &[NodeArray<'_>],
        outputs: impl FnOnce(&mut Self, &Outputs) -> Option<TokenStream>,
    ) -> TokenStream {
        let program = self.program;
        let phase = &program.phases[index];
        let element = self.statements(&phase.statements);
        self.counts.element += self.writer.take_counts();
        let nodes = &phase.nodes;
        if nodes.is_empty() {
            return element;
        }

        let graph = &program.kernel.graph;
        let sums: Vec<Ident> = nodes.sums.iter().map(|&sum| self.writer.ident(sum)).collect();
        let loads: Vec<Ident> = nodes.loads.iter().map(|&x| self.writer.ident(x)).collect();
        let load_places: Vec<TokenStream> = nodes.loads.iter().map(|&x| self.place(x)).collect();
        self.writer.begin_nodes();
        let body = self.statements(&nodes.statements);
        let accumulations: Vec<TokenStream> = nodes
            .sums
            .iter()
            .zip(&sums)
            .map(|(&sum, name)| {
                let total = self.writer.accumulated(name, graph.operands(sum)[0]);
                quote!(#name = #total;)
            })
            .collect();
        let outputs = outputs(self, &nodes.outputs);
        let stores: Vec<Ident> = nodes.stores.iter().map(|&x| self.writer.ident(x)).collect();
        let store_places: Vec<TokenStream> = nodes.stores.iter().map(|&x| self.place(x)).collect();
        let spread = self.writer.end_nodes();
        self.counts.node += self.writer.take_counts();
        self.statements +=
            2 * sums.len() + loads.len() + nodes.outputs.len() + stores.len() + spread.len() + 5;

        let head = self.head(phase, arrays);
        let (presence, total, zero) = self.around_sums(&sums);
        let spread = (self.writer.lanes == Lanes::Shape).then(|| spread_statement(&spread)).flatten();
        let totals = (!sums.is_empty()).then(|| quote!(let (#(#sums,)*) =));
        let end = totals.is_some().then(|| quote!(;));
        let (counter, kept) = self.loop_names();
        let array = format_ident!("{}", arrays[0].name);
        quote! {
            #element
            #totals {
                #spread
                #(let mut #sums = #zero;)*
                for #counter in 0..inputs.#array.len() {
                    #head
                    #presence
                    #(let #loads = #kept[#load_places];)*
                    #body
                    #(#accumulations)*
                    #outputs
                    #(#kept[#store_places] = #stores;)*
                }
                #total
            } #end
        }
    }

    /// Which nodes there are, for loops with sums; the sums as they leave a loop; and what they begin with.
    fn around_sums(&self, sums: &[Ident]) -> (Option<TokenStream>, Option<TokenStream>, TokenStream) {
        let has_sums = !sums.is_empty();
        match self.writer.lanes {
            Lanes::Shape => (
                has_sums.then(|| quote!(let presence = S::presence(S::NODES * vector, count);)),
                has_sums.then(|| quote!((#(S::total(#sums),)*))),
                quote!(T::ZERO),
            ),
            Lanes::Elements => (None, has_sums.then(|| quote!((#(#sums,)*))), quote!(E::ZERO)),
        }
    }

    /// Names of the counter and of what is kept of a node.
    fn loop_names(&self) -> (Ident, Ident) {
        match self.writer.lanes {
            Lanes::Shape => (format_ident!("vector"), format_ident!("node")),
            Lanes::Elements => (format_ident!("index"), format_ident!("kept")),
        }
    }

    /// Where a value of a node is kept.
    fn place(&mut self, expr: ExprId) -> TokenStream {
        match self.writer.lanes {
            Lanes::Shape => {
                let place = self.writer.place(expr);
                quote!(at::#place)
            }
            Lanes::Elements => {
                let place = Literal::usize_unsuffixed(self.program.place(expr));
                quote!(#place)
            }
        }
    }

    /// What is read of a node and of the arrays.
    fn head(&mut self, phase: &Phase, arrays: &[NodeArray<'_>]) -> TokenStream {
        let nodes = &phase.nodes;
        // A loop that reads stored values only has no use for a node's inputs.
        let reads = |name: &str| self.program.loop_reads(nodes, name);
        let (counter, kept) = self.loop_names();
        // Loops by index: iterators are not always inlined, see `support::simd`.
        let unused = nodes.stores.is_empty() && nodes.loads.is_empty();
        let node = (!unused).then(|| {
            if nodes.stores.is_empty() {
                quote!(let #kept = &nodes[#counter];)
            } else {
                quote!(let #kept = &mut nodes[#counter];)
            }
        });
        let arrays: Vec<TokenStream> = arrays
            .iter()
            .filter(|array| array.symbols.iter().any(|symbol| reads(symbol)))
            .map(|array| {
                let used = |symbol: &str| reads(symbol).then(|| self.ident_of_input(symbol));
                let (name, pattern) = (format_ident!("{}", array.name), (array.pattern)(&used));
                match &array.entry {
                    Some(entry) => quote!(let #pattern = #entry;),
                    None => quote!(let #pattern = inputs.#name[#counter];),
                }
            })
            .collect();
        let node_index = reads(NODE_INDEX).then(|| {
            let name = format_ident!("{NODE_INDEX}");
            match self.writer.lanes {
                Lanes::Shape => quote!(let #name = S::node_index(S::NODES * vector, count);),
                Lanes::Elements => quote!(let #name = E::splat(index as f64);),
            }
        });
        quote!(#node #(#arrays)* #node_index)
    }

    /// The identifier of an input of node scope.
    fn ident_of_input(&self, symbol: &str) -> Ident {
        let expr = self.program.node_input(symbol);
        expr.and_then(|x| self.writer.names.known(x)).unwrap_or_else(|| format_ident!("{symbol}"))
    }
}

/// Element values for all nodes, under the same names.
fn spread_statement(names: &[Ident]) -> Option<TokenStream> {
    (!names.is_empty()).then(|| quote!(#(let #names = S::spread(#names);)*))
}
