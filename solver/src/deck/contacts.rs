//! From interfaces to interactions: penalties that follow from the bodies, faces of second order, slaves that start in touch.

use std::collections::HashSet;

use diffuse_contact::faces::QuadraticFace;
use diffuse_contact::surface::{Facet, tributary_areas};

use super::error::{DeckError, Problem};
use super::{Contact, Deck, Interface, Sides};
use crate::contact::{
    AdjustError, Adjusted, ContactError, Integration, Interaction, InteractionOptions, adjust, facet_size,
};
use crate::model::Model;
use crate::solid::Solid;

/// ε without a `penalty`, over E/h. Pressures are a few percent of E at most, so that penetrations stay about a percent of a facet.
const PENALTY_FACTOR: f64 = 5.0;

impl Deck {
    /// The contacts of the deck's model; none with `contact = "none"`.
    ///
    /// # Errors
    /// [`DeckError::Invalid`]: a side does not exist or is no surface, or an option is none.
    pub fn interactions(&self, model: &Model) -> Result<Vec<Interaction>, DeckError> {
        let interfaces = self.interfaces.iter().filter(|_| self.contact != Contact::None);
        interfaces.map(|interface| self.interaction(model, interface)).collect()
    }

    fn interaction(&self, model: &Model, interface: &Interface) -> Result<Interaction, DeckError> {
        let sides = self.sides(model, interface)?;
        let quadratic = match interface.integration {
            Integration::Nodes => Vec::new(),
            Integration::Faces { .. } => quadratic_faces(model, &sides),
        };
        let options = self
            .options(model, interface, &sides)
            .with_augmentation(interface.augmentation)
            .with_refresh(interface.refresh)
            .with_tangent(interface.tangent)
            .with_two_pass(interface.two_pass)
            .with_self_contact(interface.self_contact)
            .with_friction(interface.friction.clone())
            .with_integration(interface.integration)
            .with_quadratic_faces(quadratic)
            .with_adjust(interface.adjust);
        self.refused(interface, Interaction::new(options, &sides.master, &sides.slave, &model.nodes))
    }

    /// Penalty, element and symmetry.
    fn options(&self, model: &Model, interface: &Interface, sides: &Sides) -> InteractionOptions {
        let penalty = interface.penalty.unwrap_or_else(|| automatic_penalty(model, sides));
        InteractionOptions::new(&interface.name, penalty)
            .with_interface(interface.options(self.contact))
            .with_symmetry(interface.symmetry.clone())
    }

    /// Moves the slaves that are to start in touch.
    pub(super) fn adjust(&self, model: &mut Model) -> Result<(), DeckError> {
        let interfaces = self.interfaces.iter().filter(|_| self.contact != Contact::None);
        for (interface, limit) in interfaces.filter_map(|own| Some((own, own.adjust?))) {
            let sides = self.sides(model, interface)?;
            // Over nodes and in one pass: the slaves' gaps are what is closed.
            let options = self.options(model, interface, &sides);
            let made = Interaction::new(options, &sides.master, &sides.slave, &model.nodes);
            let mut interaction = self.refused(interface, made)?;
            let (deformable, supports) = (model.deformable(), self.supports(model)?);
            let is_free = |node: usize, axis| deformable[node] && supports.is_free(3 * node + axis);
            let free: Vec<[bool; 3]> =
                (0..model.nodes.len()).map(|node| [0, 1, 2].map(|axis| is_free(node, axis))).collect();
            let Adjusted { moved, held } = match adjust(&mut interaction, &model.nodes, &free, limit) {
                Ok(adjusted) => adjusted,
                Err(AdjustError::Contact(error)) => return self.refused(interface, Err(error)),
                Err(error) => return Err(self.unadjusted(interface, error)),
            };
            moved.into_iter().for_each(|(node, to)| model.adjust(node, to, &interface.name));
            model.not_adjusted.insert(interface.name.clone(), held);
            // Of elements that this turned inside out the mesh is not to blame.
            Solid::new(&model.nodes, &model.bodies)
                .map_err(|error| self.unadjusted(interface, AdjustError::Solid(error)))?;
        }
        Ok(())
    }

    fn unadjusted(&self, interface: &Interface, error: AdjustError) -> DeckError {
        let name = interface.name.clone();
        self.error(interface.line, Problem::Adjust { name, error })
    }

    fn refused<T>(&self, interface: &Interface, made: Result<T, ContactError>) -> Result<T, DeckError> {
        made.map_err(|error| self.error(interface.line, Problem::Contact(error)))
    }
}

/// Five times the least E/h of all bodies under either side, h the size of its facets there.
fn automatic_penalty(model: &Model, sides: &Sides) -> f64 {
    let mut least = f64::INFINITY;
    for body in &model.bodies {
        let nodes: HashSet<usize> = body.elements.nodes().iter().copied().collect();
        for side in [&sides.master, &sides.slave] {
            let is_own = |facet: &&Facet| facet.corners().iter().all(|node| nodes.contains(node));
            let own: Vec<Facet> = side.iter().filter(is_own).copied().collect();
            // Facets that are no surface are refused where it is made.
            let areas = tributary_areas(&model.nodes, &own).unwrap_or_default();
            least = least.min(body.material.young / facet_size(&areas, &own));
        }
    }
    PENALTY_FACTOR * least
}

/// The faces of second order that belong wholly to a side. Others leave their facets to themselves.
fn quadratic_faces(model: &Model, sides: &Sides) -> Vec<QuadraticFace> {
    let nodes = |facets: &[Facet]| facets.iter().flat_map(Facet::corners).copied().collect();
    let sides: [HashSet<usize>; 2] = [nodes(&sides.master), nodes(&sides.slave)];
    let is_whole =
        |face: &QuadraticFace| sides.iter().any(|side| face.nodes().iter().all(|node| side.contains(node)));
    model.quadratic_faces().into_iter().filter(is_whole).collect()
}
