//! What kernels read.

use super::Lane;

/// Positions of an element's master nodes x^1 … x^n, global axes.
#[derive(Clone, Copy, Debug)]
pub enum Masters<'a> {
    /// One after another.
    Positions(&'a [[f64; 3]]),
    /// By their places among all positions.
    Indexed {
        /// Positions of all nodes.
        positions: &'a [[f64; 3]],
        /// The masters' places.
        nodes: &'a [u32],
    },
}

impl Masters<'_> {
    /// n
    #[inline(always)]
    pub const fn len(&self) -> usize {
        match self {
            Self::Positions(positions) => positions.len(),
            Self::Indexed { nodes, .. } => nodes.len(),
        }
    }

    /// Whether there are none.
    #[inline(always)]
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The k-th, counted from 0.
    ///
    /// # Panics
    /// If there is none.
    #[inline(always)]
    pub fn get(&self, k: usize) -> [f64; 3] {
        match self {
            Self::Positions(positions) => positions[k],
            Self::Indexed { positions, nodes } => positions[nodes[k] as usize],
        }
    }
}

/// Radii R_k of the master nodes' domains of influence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Domains<'a> {
    /// One around the slave, the support radius, for all nodes (Chamoret et al. 2008, eq. 14).
    #[default]
    Shared,
    /// One for each master node, length (`docs/equations.md`, T14).
    Each(&'a [f64]),
    /// One for each master node, in the first configuration (`docs/equations.md`, T18).
    Material(&'a [MaterialNode]),
}

/// A master node in the first configuration, where domains of influence stay what they are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MaterialNode {
    /// X_k − Ξ: its first position, seen from the slave's place there, length.
    pub offset: [f64; 3],
    /// Upper triangle U of its metric, rows xx, xy, xz, yy, yz, zz, 1/length: r = |U (X_k − Ξ)| is the distance over the
    /// radius of its domain.
    pub metric: [f64; 6],
}

impl MaterialNode {
    /// r
    #[inline(always)]
    pub fn distance(&self) -> f64 {
        self.square().sqrt()
    }

    /// r²
    #[inline(always)]
    pub fn square(&self) -> f64 {
        let ([x, y, z], [xx, xy, xz, yy, yz, zz]) = (self.offset, self.metric);
        let along = [xx * x + xy * y + xz * z, yy * y + yz * z, zz * z];
        along[0] * along[0] + along[1] * along[1] + along[2] * along[2]
    }
}

impl Domains<'_> {
    /// R_k of the k-th master node; of domains in the first configuration `support_radius`.
    ///
    /// # Panics
    /// If there is none.
    #[inline(always)]
    pub fn radius(&self, k: usize, support_radius: f64) -> f64 {
        match self {
            Self::Shared | Self::Material(_) => support_radius,
            Self::Each(radii) => radii[k],
        }
    }
}

/// One element. Positions are in global axes.
#[derive(Clone, Copy, Debug)]
pub struct ElementInputs<'a> {
    /// Slave node x^c.
    pub slave: [f64; 3],
    /// Master nodes.
    pub masters: Masters<'a>,
    /// Radii of their domains of influence.
    pub domains: Domains<'a>,
    /// Where the frame moves: a node's weight in the average plane is the fitting weight at this multiple of |x^k − x^c|/R_k; 0
    /// weights all nodes alike. Other frames ignore it.
    pub plane_reach: f64,
    /// First in-plane direction of the local frame.
    pub t1: [f64; 3],
    /// Second in-plane direction.
    pub t2: [f64; 3],
    /// Unit normal n̂ of the plane, outward.
    pub normal: [f64; 3],
    /// Support radius R: the length that offsets are divided by.
    pub support_radius: f64,
    /// In-plane offset from the slave at which the surface kernels evaluate, length; others ignore it.
    pub point: [f64; 2],
    /// Where the anchor is that the slip is measured from, global axes; only kernels with a slip read it.
    pub anchor: [f64; 3],
    /// Which master node is nearest to the slave in the plane (t1, t2); only kernels with an interpolating weight use
    /// it. Their results do not depend on it in exact arithmetic: another node costs digits when the slave is close to
    /// the nearest one.
    pub pole: usize,
}

impl ElementInputs<'_> {
    /// The k-th master node, counted from 0: x, y, z, and R/R_k.
    ///
    /// # Panics
    /// If there is none.
    #[inline(always)]
    pub fn node(&self, k: usize) -> [f64; NODE_VALUES] {
        let [x, y, z] = self.masters.get(k);
        let ratio = match self.domains {
            Domains::Shared | Domains::Material(_) => 1.0,
            Domains::Each(radii) => self.support_radius / radii[k],
        };
        [x, y, z, ratio]
    }

    /// Where the k-th master node is in the first configuration: X_k − Ξ and its metric. Zeros where domains are not there.
    ///
    /// # Panics
    /// If there is none.
    #[inline(always)]
    pub fn material(&self, k: usize) -> [f64; MATERIAL_VALUES] {
        let node = match self.domains {
            Domains::Material(nodes) => nodes[k],
            Domains::Shared | Domains::Each(_) => MaterialNode::default(),
        };
        let ([x, y, z], [xx, xy, xz, yy, yz, zz]) = (node.offset, node.metric);
        [x, y, z, xx, xy, xz, yy, yz, zz]
    }
}

/// Numbers that a kernel reads of each master node.
pub const NODE_VALUES: usize = 4;
/// Numbers that a kernel with domains in the first configuration reads of each master node besides.
pub const MATERIAL_VALUES: usize = 9;

/// What a kernel reads, as vectors: element values `E` and node values `T` of a [`Shape`](super::Shape). Fields as in
/// [`ElementInputs`].
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a, E, T = E> {
    /// Slave node.
    pub slave: [E; 3],
    /// Master nodes, as [`ElementInputs::node`] gives them; the last vector may hold more than there are.
    pub masters: &'a [[T; NODE_VALUES]],
    /// The same of [`ElementInputs::material`]; empty for kernels that do not read it.
    pub material: &'a [[T; MATERIAL_VALUES]],
    /// Number of master nodes.
    pub count: usize,
    /// First in-plane direction.
    pub t1: [E; 3],
    /// Second in-plane direction.
    pub t2: [E; 3],
    /// Unit normal.
    pub normal: [E; 3],
    /// Support radius.
    pub support_radius: E,
    /// Reach of the average plane's weights.
    pub plane_reach: E,
    /// Where the surface kernels evaluate.
    pub point: [E; 2],
    /// Where the anchor of the slip is.
    pub anchor: [E; 3],
    /// Index of the nearest master node, a whole number.
    pub pole: E,
    /// Which of the weights that share the kernel it is, a whole number.
    pub weight_number: E,
}

impl<'a, E: Lane, T: Lane> Inputs<'a, E, T> {
    /// The elements `at(lane)` side by side, one per lane of `E`. `masters` and `material` are theirs as
    /// vectors.
    #[inline(always)]
    pub fn gather<'e>(
        at: impl Fn(usize) -> &'e ElementInputs<'e>,
        weight_number: usize,
        masters: &'a [[T; NODE_VALUES]],
        material: &'a [[T; MATERIAL_VALUES]],
    ) -> Self {
        // Spelt out: arrays' `map` is not always inlined.
        macro_rules! vector {
            ($field:ident) => {
                [
                    E::from_fn(|lane| at(lane).$field[0]),
                    E::from_fn(|lane| at(lane).$field[1]),
                    E::from_fn(|lane| at(lane).$field[2]),
                ]
            };
        }
        Self {
            slave: vector!(slave),
            masters,
            material,
            count: at(0).masters.len(),
            t1: vector!(t1),
            t2: vector!(t2),
            normal: vector!(normal),
            support_radius: E::from_fn(|lane| at(lane).support_radius),
            plane_reach: E::from_fn(|lane| at(lane).plane_reach),
            point: [E::from_fn(|lane| at(lane).point[0]), E::from_fn(|lane| at(lane).point[1])],
            anchor: vector!(anchor),
            pole: E::from_fn(|lane| at(lane).pole as f64),
            weight_number: E::splat(weight_number as f64),
        }
    }
}
