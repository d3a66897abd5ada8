//! Whether two models are the same, without keeping one of them.

use std::hash::Hasher;

use diffuse_contact::surface::Facet;
use siphasher::sip128::{Hasher128, SipHasher13};

use super::Model;

impl Model {
    /// A number, as 32 hexadecimal digits, that two models share only if they have the same start positions bit for bit, the
    /// same elements, with or without incompatible modes, and the same sets and surfaces, in the same order. It is the same on every machine: nodes that were adjusted count
    /// where they were. Materials are not in it.
    pub fn fingerprint(&self) -> String {
        let mut digest = Digest(SipHasher13::new());
        digest.size(self.nodes.len());
        let nodes = self.nodes.iter().enumerate();
        let given =
            nodes.map(|(node, position)| self.adjusted.get(&node).map_or(position, |node| &node.before));
        for coordinate in given.flatten() {
            digest.0.write(&coordinate.to_bits().to_le_bytes());
        }
        digest.size(self.bodies.len());
        for body in &self.bodies {
            digest.text(&body.name);
            digest.size(body.elements.len());
            body.elements.iter().for_each(|cell| {
                digest.text(cell.kind.name());
                if cell.incompatible_modes {
                    digest.text("incompatible modes");
                }
            });
            digest.indices(body.elements.nodes());
        }
        digest.size(self.node_sets.len());
        for (name, nodes) in &self.node_sets {
            digest.text(name);
            digest.indices(nodes);
        }
        digest.size(self.surfaces.len());
        for (name, facets) in &self.surfaces {
            digest.text(name);
            digest.size(facets.len());
            facets.iter().map(Facet::corners).for_each(|corners| digest.indices(corners));
        }
        format!("{:032x}", digest.0.finish128().as_u128())
    }
}

/// Every list goes in with its length before it: what ends one cannot begin the next.
struct Digest(SipHasher13);

impl Digest {
    fn size(&mut self, size: usize) {
        self.0.write(&(size as u64).to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.size(text.len());
        self.0.write(text.as_bytes());
    }

    fn indices(&mut self, indices: &[usize]) {
        self.size(indices.len());
        indices.iter().for_each(|&index| self.size(index));
    }
}
