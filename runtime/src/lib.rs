//! Smooth 3D contact: the diffuse contact element of Chamoret, Rassineux and Bergheau (2008).
//!
//! For every slave node the gap g to a smooth surface through the master nodes, its gradient N and its Hessian M with respect to the
//! coordinates of all nodes involved. All in global axes, ordered slave, master 1, …, master n.
//!
//! # A whole interface
//!
//! [`ContactInterface`] pairs slave nodes with a [`MasterSurface`] and evaluates them in parallel. [`assembly`] makes force and tangent of
//! the contacts.
//!
//! ```
//! use diffuse_contact::{ContactInterface, ContactLaw, DofMap, Facet, InterfaceOptions, MasterSurface, Mode, add_forces};
//!
//! // 8 × 8 master facets in the plane z = 0, outside above, and one slave node 0.1 deep.
//! let mut positions: Vec<[f64; 3]> = (0..81).map(|k| [f64::from(k % 9), f64::from(k / 9), 0.0]).collect();
//! let facets = (0..64).map(|k| k % 8 + 9 * (k / 8)).map(|k| Facet::Quadrilateral([k, k + 1, k + 10, k + 9]));
//! let master = MasterSurface::new(&positions, facets.collect())?;
//! positions.push([4.2, 3.9, -0.1]);
//! let mut interface = ContactInterface::new(master, vec![81], &[], &positions, InterfaceOptions::default())?;
//!
//! interface.refresh_pairing(&positions)?; // once an increment
//! interface.follow(&positions)?; // each iteration
//! let contacts = interface.evaluate(Mode::Hessian)?;
//! let (dofs, mut force) = (DofMap::standard(82), vec![0.0; 3 * 82]);
//! add_forces(contacts, &ContactLaw::penalty(1e3), &dofs, &mut force)?;
//! assert!((force[3 * 81 + 2] - 100.0).abs() < 1e-9); // ε × depth, outward on the slave
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # One element
//!
//! Codes with their own contact search hand over one slave node with its masters.
//!
//! ```
//! use diffuse_contact::{Backend, Element, Frame, Generated, Mode};
//!
//! let masters: Vec<[f64; 3]> = (0..9).map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.0]).collect();
//! let frame = Frame::average_plane(&masters, [0.0, 0.0, 1.0])?; // outward side: +z
//! let element = Element::new([0.1, 0.2, -0.01], &masters, frame, 2.0); // support radius 2
//! let contact = Generated.gap(&element, Mode::Hessian)?;
//! assert!((contact.gap + 0.01).abs() < 1e-14);
//! assert_eq!(contact.gradient.len(), 30);
//! # Ok::<(), diffuse_contact::ElementError>(())
//! ```
//!
//! # Where to look
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`interface`], [`surface`] | whole interfaces: pairing, evaluation, outcomes; facets, sheets, borders |
//! | [`faces`] | contact integrated over the slave's faces: exact patch test |
//! | [`assembly`] | contact force and tangent, as triplets or compressed rows |
//! | [`element`], [`frame`], [`output`], [`error`](mod@error) | one element, its input and results |
//! | [`facet`] | the classic element, a node against one facet |
//! | [`neighbourhood`], [`pairing`] | which masters carry a fit, without a surface |
//! | [`backend`], [`generated`] | who computes: the kernels, or automatic differentiation (feature `ad`) |
//!
//! Errors carry figures and a stable `code()`. Normals point out of the master; g > 0 apart, g < 0 penetrating. The force −ε g N stands on
//! the side of the external loads, and the tangent is its negative derivative (Chamoret et al. 2008, eqs. 33 and 43).
#![forbid(unsafe_code)]

#[cfg(feature = "ad")]
pub mod ad;
pub mod affine;
pub mod assembly;
pub mod backend;
pub mod batch;
pub mod eigen;
pub mod element;
pub mod error;
pub mod faces;
pub mod facet;
pub mod foot;
pub mod frame;
pub mod friction;
pub mod generated;
pub mod interface;
mod kernels;
pub mod material;
pub mod neighbourhood;
pub mod output;
pub mod pairing;
pub mod product;
mod scratch;
pub mod surface;
pub mod threads;
mod vector;
mod weight;
mod with;

pub use affine::AffinePoint;
pub use assembly::{ContactLaw, CsrPattern, DofMap, TangentOperator, Triplets, add_forces};
pub use backend::Backend;
pub use batch::{BatchScratch, GapSlot};
pub use diffuse_contact_kernels::support::{Basis, CustomBasis, Domains, MaterialNode, Mode};
pub use element::{Element, Weight};
pub use error::ElementError;
pub use facet::{FacetElement, FacetPoint};
pub use foot::{FootDerivatives, FootSlot};
pub use frame::{Frame, FrameDerivative};
pub use friction::{Coulomb, FrictionState};
pub use generated::{Generated, GeneratedWith};
pub use interface::{ContactInterface, InterfaceOptions};
pub use material::{MaterialDomain, MaterialPlace};
pub use output::{Coefficients, ContactPoint, Gap, Slip, Surface, SymmetricMatrix};
pub use product::{GapFactors, HessianFactors, HessianForm};
pub use surface::{Facet, MasterSurface};

/// A point or a vector in global axes, in the length unit of the mesh.
pub type Point = [f64; 3];

/// The pages whose programs are run with the documentation tests.
#[cfg(doctest)]
mod pages {
    #[doc = include_str!("../../README.md")]
    pub struct Readme;

    #[doc = include_str!("../README.md")]
    pub struct OfTheCrate;

    #[doc = include_str!("../../docs/how-to/rust.md")]
    pub struct Rust;

    #[doc = include_str!("../../docs/how-to/pressures.md")]
    pub struct Pressures;

    #[doc = include_str!("../../docs/how-to/friction.md")]
    pub struct Friction;

    #[doc = include_str!("../../docs/tutorial/first-host.md")]
    pub struct FirstHost;
}
