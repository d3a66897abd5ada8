//! The tests of the public interface. Those that count allocations are programs of their own, with an allocator each.

#[cfg(feature = "ad")]
mod ad;
mod assembly;
mod assembly_cases;
mod assembly_single;
#[cfg(feature = "ad")]
mod co_moving;
mod common;
mod cutback;
mod domains;
mod elements;
mod faces;
mod foot;
mod interface_facets;
#[cfg(feature = "friction")]
mod interface_friction;
mod interface_geometry;
mod interface_pairing;
#[cfg(feature = "ad")]
mod interface_robustness;
mod interface_where;
mod kept_lists;
mod neighbourhood_cases;
mod neighbourhood_fits;
mod neighbourhood_layers;
mod operator;
mod pairing;
mod refused_friction;
mod self_contact;
mod self_contact_faces;
mod sheets;
#[cfg(feature = "ad")]
mod strips;
mod surface;
mod windows;
