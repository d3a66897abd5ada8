//! From contact elements to the equations of a solver: vector of contact forces, triplets, compressed rows.
//!
//! The input is any list of [`Elements`]; a [`ContactLaw`] says which of them carry force and how much; a [`DofMap`]
//! says which equation a displacement has. The products of gap, gradient and Hessian that make up forces and tangent
//! are formed entry by entry where the sums below add them; no element matrix is stored.
//!
//! * [`add_forces`] adds the contact forces to a vector.
//! * [`Triplets`] lists the entries of the tangent, for solvers that sort and sum themselves.
//! * [`CsrPattern`] is built once for a pairing and then filled at every iteration, in parallel.
//! * [`TangentOperator`] multiplies the tangent of an interface with vectors, without making it.
//! * [`slave_friction`] says what friction does at each slave.
//! * [`Tangent::adaptive`] says which tangent the next linear solution had better have.
//! * [`ContactLaw::element_system`] makes forces and dense tangent of one element by itself,
//!   [`ContactLaw::element_tangent`] the tangent's lower triangle.
//!
//! Every sum is formed in the order of the elements, and within an element in the order of its nodes. So the result is,
//! bit for bit, the one of a plain loop over the elements, for any number of threads.
//!
//! ```
//! use diffuse_contact::assembly::{ContactLaw, CsrPattern, DofMap, ElementView, add_forces};
//! use diffuse_contact::{Backend, Basis, Element, Frame, Generated, Mode, Weight};
//!
//! // Nodes 0 to 8 are a flat master surface, node 9 penetrates it by 0.01.
//! let masters: Vec<[f64; 3]> =
//!     (0..9).map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.0]).collect();
//! let element = Element::new([0.1, 0.2, -0.01], &masters, Frame::average_plane(&masters, [0.0, 0.0, 1.0])?, 2.0);
//! let gap = Generated.gap(&element, Mode::Hessian)?;
//! let nodes: Vec<u32> = (0..9).collect();
//! let elements = [ElementView::new(9, &nodes, &gap)];
//!
//! let law = ContactLaw::penalty(1e5);
//! let dofs = DofMap::standard(10);
//! let mut forces = vec![0.0; dofs.equations()];
//! let active = add_forces(elements.as_slice(), &law, &dofs, &mut forces)?;
//! assert_eq!(active, 1);
//! // The slave is pushed out along +z.
//! assert!((forces[3 * 9 + 2] - 1e3).abs() < 1e-9);
//!
//! let pattern = CsrPattern::union(elements.as_slice(), &dofs)?;
//! let mut values = vec![0.0; pattern.entries()];
//! pattern.fill(elements.as_slice(), &law, &mut values)?;
//! let entry = pattern.position(29, 29).unwrap();
//! assert!((values[entry] - 1e5).abs() < 1e-7);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod active;
mod dofs;
mod elements;
mod error;
mod forces;
mod law;
mod normal;
mod operator;
mod pattern;
mod single;
mod slave_friction;
mod tangent;
mod triplets;

pub use dofs::DofMap;
pub use elements::{ContactView, ElementView, Elements, SlipView};
pub use error::AssemblyError;
pub use forces::add_forces;
pub use law::ContactLaw;
pub(crate) use normal::Table;
pub use normal::{NormalLaw, NormalPressure, TabulatedPressure};
pub use operator::TangentOperator;
pub use pattern::{CsrIndex, CsrMap, CsrPattern};
pub use slave_friction::{SlaveFriction, slave_friction};
pub use tangent::Tangent;
pub use triplets::{Triangle, Triplets};

/// Adds a number to an entry of a vector, which has to be finite afterwards.
pub(crate) fn add_entry(
    what: &'static str,
    entries: &mut [f64],
    equation: usize,
    value: f64,
) -> Result<(), AssemblyError> {
    entries[equation] += value;
    if entries[equation].is_finite() { Ok(()) } else { Err(AssemblyError::Overflow { what, equation }) }
}

/// An empty vector with room for `count` of `what`: an error where there is no memory, not the end of the program.
fn reserve<T>(what: &'static str, count: usize) -> Result<Vec<T>, AssemblyError> {
    let mut vector = Vec::new();
    vector.try_reserve_exact(count).map_err(|_| AssemblyError::TooLarge { what, count })?;
    Ok(vector)
}

/// So many zeros, in memory that the system hands over page by page when it is used: by all threads where they share the work.
fn zeros<T: Clone + Default>(what: &'static str, count: usize) -> Result<Vec<T>, AssemblyError> {
    drop(reserve::<T>(what, count)?);
    Ok(vec![T::default(); count])
}

/// So many numbers, which are all to be written, in memory that is there already if it is large enough: its pages need not come again.
fn in_memory<T: Clone + Default>(
    what: &'static str,
    count: usize,
    mut memory: Vec<T>,
) -> Result<Vec<T>, AssemblyError> {
    if memory.capacity() < count {
        return zeros(what, count);
    }
    memory.resize(count, T::default());
    Ok(memory)
}
