//! The forces vector.

use super::law::{Needs, check};
use super::{AssemblyError, ContactLaw, DofMap, Elements, add_entry};

/// Adds the contact forces R = Σ f_k N_k on the nodes to `forces`, one entry per equation, in the order of the
/// elements. Returns the number of elements that carry force.
///
/// # Errors
/// [`AssemblyError::OutputLength`] if `forces` has not one entry per equation, and every reason for which the law or
/// an element is refused; `forces` is then unchanged. [`AssemblyError::Overflow`] if a sum is not finite; the contents
/// of `forces` are then unspecified.
pub fn add_forces<E: Elements + ?Sized>(
    elements: &E,
    law: &ContactLaw<'_>,
    dofs: &DofMap,
    forces: &mut [f64],
) -> Result<usize, AssemblyError> {
    AssemblyError::check_length("forces", forces.len(), dofs.equations())?;
    check(elements, law, dofs.nodes(), Needs::Residual)?;
    let mut count = 0;
    for k in 0..elements.len() {
        let Some(active) = law.active(elements, k) else { continue };
        count += 1;
        for (local, node) in elements.element(k).nodes().enumerate() {
            for (axis, equation) in dofs.of_node(node).into_iter().enumerate() {
                if let Some(equation) = equation {
                    add_entry("forces", forces, equation, active.contact_force(3 * local + axis))?;
                }
            }
        }
    }
    Ok(count)
}
