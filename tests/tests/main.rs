//! All tests but that of allocations, which is a program of its own.

#[cfg(feature = "generator")]
mod codegen_output;
#[cfg(all(feature = "bases", feature = "generator"))]
mod custom_basis;
#[cfg(feature = "generator")]
mod custom_weight;
#[cfg(feature = "generator")]
mod deep_formulas;
mod documents;
#[cfg(feature = "generator")]
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
#[cfg(feature = "generator")]
mod materials;
mod node_below_slave;
mod products;
mod scales;
mod statuses;
mod weights;
