//! All tests but that of allocations, which is a program of its own.

mod codegen_output;
#[cfg(feature = "bases")]
mod custom_basis;
mod custom_weight;
mod deep_formulas;
mod documents;
mod elements;
mod every_size;
mod facet_kernels;
mod facet_lanes;
mod facet_statuses;
mod facets;
mod foot;
#[cfg(feature = "friction")]
mod friction;
mod identities;
mod lanes;
mod materials;
mod node_below_slave;
mod products;
mod scales;
mod statuses;
mod weights;
