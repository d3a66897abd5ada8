//! Parts that only friction holds, without a force that it could come from. Normal forces of rounding have a stiffness of friction all the
//! same, and the next increment begins wherever that leads.

use diffuse_contact::Mode;
use diffuse_contact::assembly::Tangent;

use super::linear::{NEAR, motions};
use super::{Failure, Loose, Problem, StaticsError};
use crate::contact::Bodies;

/// A part on which contact acts with forces that are none.
struct Unloaded {
    name: String,
    nodes: Vec<usize>,
    force: f64,
    noise: f64,
}

impl Problem {
    /// Refuses an equilibrium at `positions` in which friction alone holds a part, and contact acts on it with no more than equilibrium is known
    /// to, `allowed` and rounding, neither here nor at `before`, the end of the increment before, if there was one. What is unloaded right
    /// now stays where friction held it.
    pub(super) fn check_loads(
        &mut self,
        (time, reached): (f64, f64),
        positions: &[[f64; 3]],
        before: Option<&[[f64; 3]]>,
        allowed: f64,
    ) -> Result<(), Failure> {
        if self.active() == 0 || self.stabilisation > 0.0 || !self.contacts.has_friction() {
            return Ok(());
        }
        let mut unloaded = self.unloaded(&self.contact, allowed);
        if let Some(before) = before.filter(|_| !unloaded.is_empty()) {
            let mut forces = vec![0.0; self.contact.len()];
            self.contacts.evaluate(before, Mode::Gradient)?;
            self.contacts.add_internal_forces(&mut forces)?;
            unloaded.retain(|part| norm(&forces, &part.nodes) <= part.noise);
            self.contacts.evaluate(positions, Mode::Hessian)?;
        }
        if unloaded.is_empty() {
            return Ok(());
        }
        let is_one = |name: &String| unloaded.iter().any(|part| part.name == *name);
        let loose = self.without_friction(time, positions, &unloaded)?;
        let loose: Vec<Loose> = loose.into_iter().filter(|loose| loose.parts.iter().any(is_one)).collect();
        if motions(&loose) == 0 {
            return Ok(());
        }
        let largest = |of: fn(&Unloaded) -> f64| unloaded.iter().map(of).fold(0.0, f64::max);
        let (force, noise) = (largest(|part| part.force), largest(|part| part.noise));
        Err(Failure::Fatal(StaticsError::Unloaded { time: reached, loose, force, noise }))
    }

    /// Parts with contact that is noise.
    fn unloaded(&self, contact: &[f64], allowed: f64) -> Vec<Unloaded> {
        let part = |(name, nodes): &(String, Vec<usize>)| {
            let (force, noise) = (norm(contact, nodes), allowed + norm(&self.rounding, nodes));
            let unloaded = || Unloaded { name: name.clone(), nodes: nodes.clone(), force, noise };
            (force > 0.0 && force <= noise).then(unloaded)
        };
        self.solid.parts().iter().filter_map(part).collect()
    }

    /// What would be loose without friction, with all contact of these parts closed.
    fn without_friction(
        &mut self,
        time: f64,
        positions: &[[f64; 3]],
        unloaded: &[Unloaded],
    ) -> Result<Vec<Loose>, Failure> {
        let nodes = unloaded.iter().map(|part| &part.nodes[..]).enumerate();
        let bodies = Bodies::new(positions.len(), nodes);
        self.contacts.leave_out_friction(true);
        let system = match self.contacts.suppose(positions, &bodies, NEAR) {
            Ok(()) => self.assemble(time, positions, Some(Tangent::GaussNewton)),
            Err(error) => Err(Failure::Contact(error)),
        };
        self.contacts.leave_out_friction(false);
        self.contacts.recall(positions)?;
        let system = system?;
        let loose = self.loose(&system, positions);
        self.stiffness = Some(system.matrix);
        Ok(loose)
    }
}

/// The root of the sum of squares over some nodes of three numbers for each; 0 where there are none.
fn norm(numbers: &[f64], nodes: &[usize]) -> f64 {
    let of = |&node: &usize| numbers.get(3 * node..3 * node + 3).unwrap_or_default();
    nodes.iter().flat_map(of).map(|x| x * x).sum::<f64>().sqrt()
}
