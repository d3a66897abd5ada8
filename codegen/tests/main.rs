//! The tests of the public interface.

mod config;
mod element;
mod element_c;
mod element_choices;
mod element_known;
mod element_nodes;
mod element_points;
mod element_products;
mod element_roots;
mod emitted;
mod formulas;
mod golden;
mod operations;
mod simplified;
mod witnesses;
