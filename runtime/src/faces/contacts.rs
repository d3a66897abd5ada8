//! The contact of all slave nodes, with pressures averaged to them.

use crate::assembly::{AssemblyError, DofMap, Tangent, Triplets, add_entry};
use crate::friction::FrictionState;
use crate::interface::{NoContact, Outcome};
use crate::{Mode, Point};

/// The contact of one node of the slave's surface: what the points of its faces in one sheet give on average.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeContact {
    /// The node.
    pub slave: usize,
    /// Whether there are points with a contact element around it; if not, the reason of one of them.
    pub outcome: Outcome,
    /// ḡ_A = ∫ N_A g dA / ∫ N_A dA, length.
    pub gap: f64,
    /// The smallest g of the points of the faces around it, length.
    pub smallest_gap: f64,
    /// ∫ N_A dA over the points that lie over the master, length².
    pub area: f64,
    /// Mean unit normal of the master; zero without contact.
    pub normal: Point,
    /// p_A ≥ 0, force per area; where [points](super::FacePressures::Points) have pressures the average of theirs.
    pub pressure: f64,
    /// −∂p_A/∂ḡ_A of a node in contact, force per length³: the penalty, but for a normal law of one's own. Where points have pressures
    /// the average of their −∂p/∂g.
    pub stiffness: f64,
    /// t_A, friction on the slave, force per area; zero without friction or before there is a history.
    pub friction: Point,
    /// Stick, slip or neither.
    pub friction_state: FrictionState,
    /// From the anchor, or of a node that was open from its place of touch, length: the elastic slip, and where it slides what it has slid
    /// in the step besides. With [augmentation](crate::Coulomb::with_augmentation) from where it stuck, without its multiplier.
    pub slip: f64,
}

impl NodeContact {
    /// Without contact, for this reason.
    pub(super) const fn without(slave: usize, reason: NoContact) -> Self {
        Self {
            slave,
            outcome: Outcome::None(reason),
            gap: 0.0,
            smallest_gap: f64::INFINITY,
            area: 0.0,
            normal: [0.0; 3],
            pressure: 0.0,
            stiffness: 0.0,
            friction: [0.0; 3],
            friction_state: FrictionState::Open,
            slip: 0.0,
        }
    }

    /// p_A times the area over the master, force.
    pub fn force(&self) -> f64 {
        self.pressure * self.area
    }
}

/// A node that carries a pressure, with what follows from it: R = p_A F + Σ t_i W_i, ∂p_A/∂x = −ε G.
#[derive(Clone, Debug)]
pub(super) struct NodeBlock {
    /// Its place among the slave's nodes.
    pub node: usize,
    /// Nodes that forces act on, ascending.
    pub rows: Vec<u32>,
    /// Nodes that they depend on, ascending: the rows, too.
    pub columns: Vec<u32>,
    /// F by the rows' nodes, force by unit pressure, length².
    pub forces: Vec<f64>,
    /// G = ∂ḡ_A/∂x by the columns' nodes.
    pub gradient: Vec<f64>,
    /// p_A, force per area.
    pub pressure: f64,
    /// ε, force per length³.
    pub stiffness: f64,
    /// With a traction.
    pub friction: Option<FrictionBlock>,
}

/// The traction of a node.
#[derive(Clone, Debug)]
pub(super) struct FrictionBlock {
    /// t_A, force per area.
    pub traction: Point,
    /// W_i by the rows' nodes: force by each component of the traction, length².
    pub forces: [Vec<f64>; 3],
    /// ∂t_i/∂x by the columns' nodes with the normal held, force per length³.
    pub gradients: [Vec<f64>; 3],
    /// What turning of the normal adds to them; empty below Hessian mode.
    pub turning: [Vec<f64>; 3],
}

impl NodeBlock {
    /// What it exerts on a coordinate of its rows' nodes.
    pub fn force(&self, row: usize) -> f64 {
        let normal = self.pressure * self.forces[row];
        self.friction.as_ref().map_or(normal, |friction| normal + friction.force(row))
    }
}

impl FrictionBlock {
    /// What the traction exerts on a coordinate of the rows' nodes.
    pub fn force(&self, row: usize) -> f64 {
        (0..3).map(|axis| self.traction[axis] * self.forces[axis][row]).sum()
    }
}

/// The contact forces and the tangent of all slave faces.
#[derive(Clone, Debug)]
pub struct FaceContacts {
    pub(super) nodes: Vec<NodeContact>,
    pub(super) blocks: Vec<NodeBlock>,
    pub(super) faces: Vec<FacePart>,
    /// Of all points, if they have pressures of their own.
    pub(super) pressures: Vec<f64>,
    /// Whether each point has a contact.
    pub(super) found: Vec<bool>,
    pub(super) missed: usize,
    pub(super) mode: Mode,
}

/// What a face has that is not its nodes'.
#[derive(Clone, Debug)]
pub(super) struct FacePart {
    /// Its number.
    pub face: usize,
    /// Nodes that forces act on, ascending.
    pub rows: Vec<u32>,
    /// Nodes that they depend on, ascending: the rows, too.
    pub columns: Vec<u32>,
    /// ∫ p R dA by the rows' nodes without friction, with pressures of points; else empty.
    pub pressed: Vec<f64>,
    /// ∫ ε R ∂g/∂x dA, with pressures of points; else empty.
    pub by_gaps: Vec<f64>,
    /// What the directions of its forces add to the tangent: −∂R/∂x with the pressures held; empty below Hessian mode.
    pub directions: Vec<f64>,
}

impl FacePart {
    /// Its largest arrays.
    pub fn into_memory(self) -> impl Iterator<Item = Vec<f64>> {
        [self.by_gaps, self.directions].into_iter().filter(|entries| entries.capacity() > 0)
    }

    /// The parts of a tangent that are there.
    pub fn tangents(&self, tangent: Tangent) -> impl Iterator<Item = &[f64]> {
        let turning = Some(&self.directions).filter(|_| tangent == Tangent::Exact);
        [Some(&self.by_gaps), turning].into_iter().flatten().map(Vec::as_slice).filter(|own| !own.is_empty())
    }
}

/// A part of the tangent: a dense block.
#[derive(Clone, Copy, Debug)]
pub struct TangentBlock<'a> {
    /// Nodes of its rows, three each.
    pub rows: &'a [u32],
    /// Nodes of its columns, three each.
    pub columns: &'a [u32],
    /// Its entries row by row, force per length.
    pub entries: &'a [f64],
}

impl Default for FaceContacts {
    fn default() -> Self {
        let (nodes, blocks, faces) = (Vec::new(), Vec::new(), Vec::new());
        let (pressures, found) = (Vec::new(), Vec::new());
        Self { nodes, blocks, faces, pressures, found, missed: 0, mode: Mode::Value }
    }
}

impl FaceContacts {
    /// The nodes of the slave's surface, as [`slaves`](super::FaceInterface::slaves) has them.
    pub fn nodes(&self) -> &[NodeContact] {
        &self.nodes
    }

    /// Number of nodes that carry pressure.
    pub fn active(&self) -> usize {
        self.nodes.iter().filter(|node| node.pressure > 0.0).count()
    }

    /// Points of loaded faces that carry no force although they should: those below their facet whose element has no result, those without a
    /// place on their own face or the facet, those whose line of force meets no place of the facet, and those whose derivatives overflow.
    pub const fn missed(&self) -> usize {
        self.missed
    }

    /// Hands over what friction alone exerts on each node, several times for a node that several slaves act on; nothing without
    /// derivatives.
    pub fn for_each_friction(&self, mut f: impl FnMut(u32, Point)) {
        for block in &self.blocks {
            let Some(friction) = &block.friction else { continue };
            for (place, &node) in block.rows.iter().enumerate() {
                f(node, [0, 1, 2].map(|axis| friction.force(3 * place + axis)));
            }
        }
    }

    /// Adds the contact forces on the nodes to `forces`, one entry per equation. Returns the number of nodes that carry pressure.
    ///
    /// # Errors
    /// [`AssemblyError::OutputLength`], [`AssemblyError::UnknownNode`], [`AssemblyError::NotDerived`]: `forces` is then unchanged.
    /// [`AssemblyError::Overflow`] if a sum is not finite; the contents of `forces` are then unspecified.
    pub fn add_forces(&self, dofs: &DofMap, forces: &mut [f64]) -> Result<usize, AssemblyError> {
        AssemblyError::check_length("forces", forces.len(), dofs.equations())?;
        self.check(dofs, Mode::Gradient)?;
        let mut add = |rows: &[u32], force: &dyn Fn(usize) -> f64| {
            for (node, place) in rows.iter().zip(0..) {
                for axis in 0..3 {
                    if let Some(equation) = dofs.equation(*node as usize, axis) {
                        add_entry("forces", forces, equation, force(3 * place + axis))?;
                    }
                }
            }
            Ok(())
        };
        self.blocks.iter().try_for_each(|block| add(&block.rows, &|row| block.force(row)))?;
        let pressed = self.faces.iter().filter(|part| !part.pressed.is_empty());
        pressed.into_iter().try_for_each(|part| add(&part.rows, &|row| part.pressed[row]))?;
        Ok(self.active())
    }

    pub(super) fn check(&self, dofs: &DofMap, needed: Mode) -> Result<(), AssemblyError> {
        let nodes = dofs.nodes();
        if self.mode < needed && self.nodes.iter().any(|node| node.pressure > 0.0) {
            return Err(AssemblyError::NotDerived { needed, found: self.mode });
        }
        let of_nodes = self.blocks.iter().map(|block| (block.node, &block.columns));
        let of_faces = self.faces.iter().map(|part| (part.face, &part.columns));
        for (element, columns) in of_nodes.chain(of_faces) {
            if let Some(&node) = columns.last().filter(|&&node| node as usize >= nodes) {
                return Err(AssemblyError::UnknownNode { element, node: node as usize, nodes });
            }
        }
        Ok(())
    }

    /// Hands over the tangent K = −∂R/∂x block by block, in an order that follows from the faces: ε F Gᵀ − Σ W_i ∂t_i/∂x of each node that
    /// carries pressure, and with [`Tangent::Exact`] what turning of normals and of the directions of the forces adds, as far as the
    /// evaluation was for it. It is not symmetric.
    ///
    /// # Errors
    /// [`AssemblyError::TooLarge`] where there is no memory for a block. Some may have been handed over before.
    pub fn for_each_tangent(
        &self,
        tangent: Tangent,
        mut f: impl FnMut(TangentBlock<'_>),
    ) -> Result<(), AssemblyError> {
        let mut entries: Vec<f64> = Vec::new();
        for block in &self.blocks {
            entries.clear();
            let count = block.forces.len().saturating_mul(block.gradient.len());
            let too_large = |_| AssemblyError::TooLarge { what: "entries of a block", count };
            entries.try_reserve(count).map_err(too_large)?;
            entries.extend(block.forces.iter().flat_map(|force| {
                let factor = block.stiffness * force;
                block.gradient.iter().map(move |g| factor * g)
            }));
            if let Some(friction) = &block.friction {
                let turning = friction.turning.iter().filter(|_| tangent == Tangent::Exact);
                let held = friction.forces.iter().zip(&friction.gradients);
                for (forces, gradient) in held.chain(friction.forces.iter().zip(turning)) {
                    for (row, force) in entries.chunks_exact_mut(gradient.len().max(1)).zip(forces) {
                        row.iter_mut().zip(gradient).for_each(|(entry, by)| *entry -= force * by);
                    }
                }
            }
            f(TangentBlock { rows: &block.rows, columns: &block.columns, entries: &entries });
        }
        for part @ FacePart { rows, columns, .. } in &self.faces {
            part.tangents(tangent).for_each(|entries| f(TangentBlock { rows, columns, entries }));
        }
        Ok(())
    }

    /// The tangent as triplets; zeros are left out.
    ///
    /// # Errors
    /// [`AssemblyError::UnknownNode`], [`AssemblyError::NotDerived`], [`AssemblyError::Overflow`], [`AssemblyError::TooLarge`].
    pub fn triplets(&self, tangent: Tangent, dofs: &DofMap) -> Result<Triplets, AssemblyError> {
        self.check(dofs, if tangent == Tangent::Exact { Mode::Hessian } else { Mode::Gradient })?;
        let (mut triplets, mut error) = (Triplets::new(), None);
        self.for_each_tangent(tangent, |block| {
            let width = 3 * block.columns.len();
            if let Err(full) = triplets.reserve(3 * block.rows.len(), width) {
                error.get_or_insert(full);
            }
            if error.is_some() {
                return;
            }
            for (p, row) in block.entries.chunks_exact(width.max(1)).enumerate() {
                let Some(equation) = dofs.equation(block.rows[p / 3] as usize, p % 3) else { continue };
                for (q, &value) in row.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                    if !value.is_finite() {
                        error.get_or_insert(AssemblyError::Overflow { what: "values", equation });
                    }
                    if let Some(column) = dofs.equation(block.columns[q / 3] as usize, q % 3) {
                        triplets.push(equation, column, value);
                    }
                }
            }
        })?;
        error.map_or(Ok(triplets), Err)
    }
}
