//! What an interaction exerts in all.

use diffuse_contact::Point;

use super::{Integration, Interaction, SlaveState};

/// The contact of a pair of surfaces as one force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Resultant {
    /// What the master's surface exerts on the slave's, force, exactly as it enters equilibrium. What a surface exerts on itself is
    /// nothing, but for what planes of symmetry carry.
    pub force: Point,
    /// Its moment about the origin, force · length.
    pub moment: Point,
    /// Sum of the moduli of the normal forces, force: over the area it is the mean pressure.
    pub normal: f64,
    /// Sum of the moduli of friction, force: over the area it is the mean traction.
    pub friction: f64,
    /// Area of the slave that carries force, length²: of its nodes at the start, over faces the part of them over the master. With two
    /// passes that of the larger side, in contact of a surface with itself the mean of both.
    pub area: f64,
    /// Where the normal forces act on the slave: Σ f x / Σ f. The origin without any.
    pub centre: Point,
    /// Σ f d / 2 over the normal forces of slaves that something moves and their penetrations, energy: without augmentation what the springs of
    /// the penalty store.
    pub penalty_energy: f64,
}

impl Resultant {
    /// Adds a force at `x`, with its moment.
    fn add(&mut self, x: Point, force: Point) {
        for axis in 0..3 {
            let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
            self.force[axis] += force[axis];
            self.moment[axis] += x[next] * force[last] - x[last] * force[next];
        }
    }
}

impl Interaction {
    /// Forces of the last evaluation, at the positions it was for.
    pub fn resultant(&self, positions: &[Point]) -> Resultant {
        let mut sum = Resultant::default();
        let is_own = self.options().self_contact;
        if is_own {
            // The masters are nodes of the same surface.
            let all = self.nodal_forces(positions.len()).forces;
            positions.iter().zip(all).for_each(|(&x, force)| sum.add(x, force));
        }
        for (sign, pass) in [1.0, -1.0].into_iter().zip(self.passes()) {
            let by_points = pass.has_point_pressures();
            let mut area = 0.0;
            for slave in pass.slaves() {
                let x = positions[slave.node];
                if !is_own {
                    sum.add(x, slave.nodal_force.map(|f| sign * f));
                }
                // The second pass has its points on the same surface in contact.
                (0..3).for_each(|axis| sum.centre[axis] += slave.force * x[axis]);
                sum.normal += slave.force;
                if !slave.is_held && !by_points {
                    sum.penalty_energy += 0.5 * slave.force * (-slave.gap.unwrap_or(0.0)).max(0.0);
                }
                sum.friction += slave.friction.iter().map(|f| f * f).sum::<f64>().sqrt();
                area += self.loaded_area(&slave);
            }
            if by_points {
                let points = pass.pressed();
                area = points.area;
                if pass.slaves().any(|slave| !slave.is_held) {
                    sum.penalty_energy += points.stored;
                }
            }
            // In two passes both sides carry force, but at the beginning of contact.
            sum.area = sum.area.max(area);
        }
        if is_own {
            sum.area *= 0.5;
        }
        if sum.normal > 0.0 {
            sum.centre = sum.centre.map(|moment| moment / sum.normal);
        }
        sum
    }

    /// The area of a slave that carries force.
    fn loaded_area(&self, slave: &SlaveState) -> f64 {
        let has_force = slave.force > 0.0;
        match self.options().integration {
            Integration::Nodes if has_force => self.tributary_area(slave.node),
            Integration::Faces { .. } if has_force => slave.area,
            _ => 0.0,
        }
    }
}
