//! What an element that carries force contributes: its force and the entries of its tangent.

use diffuse_contact_kernels::support::{Vector, packed_row};

use super::{AssemblyError, SlipView};
use crate::friction::FrictionForce;

/// An element that carries force.
#[derive(Clone, Copy, Debug)]
pub(super) struct Active<'a> {
    /// f, force.
    pub force: f64,
    /// ε, force per length.
    pub stiffness: f64,
    /// N.
    pub gradient: &'a [f64],
    /// M, packed lower triangle, if it takes part.
    pub hessian: Option<&'a [f64]>,
    pub friction: Option<ActiveFriction<'a>>,
}

/// The friction of an element that carries force.
#[derive(Clone, Copy, Debug)]
pub(super) struct ActiveFriction<'a> {
    pub force: FrictionForce,
    pub slip: SlipView<'a>,
}

/// What is not symmetric in the tangent of an element: a factor times ∇q Nᵀ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Skew<'a> {
    pub factor: f64,
    /// ∇q.
    pub slip: &'a [f64],
}

impl<'a> Active<'a> {
    /// ε, a symmetric rest, and what is not symmetric: together the tangent.
    pub fn split(self) -> (f64, Self, Option<Skew<'a>>) {
        let skew = self.friction.filter(|friction| friction.force.factor_by_gap != 0.0);
        let skew =
            skew.map(|friction| Skew { factor: friction.force.factor_by_gap, slip: friction.slip.gradient });
        let without = |friction: ActiveFriction<'a>| ActiveFriction {
            force: FrictionForce { factor_by_gap: 0.0, ..friction.force },
            ..friction
        };
        (self.stiffness, Self { stiffness: 0.0, friction: self.friction.map(without), ..self }, skew)
    }
}

impl Active<'_> {
    /// Entry p of the contact force.
    pub fn contact_force(&self, p: usize) -> f64 {
        let normal = self.force * self.gradient[p];
        self.friction.map_or(normal, |friction| normal - friction.force.factor * friction.slip.gradient[p])
    }

    /// Looks at M from one end to the other, so that the processor fetches it in order: columns of a packed triangle are far apart.
    pub fn look(&self) {
        let bits = |bits, number: &f64| bits ^ number.to_bits();
        std::hint::black_box(self.hessian.unwrap_or_default().iter().step_by(8).fold(0, bits));
    }

    /// Number of nodes.
    pub const fn nodes(&self) -> usize {
        self.gradient.len() / 3
    }

    /// Whether the tangent is symmetric.
    pub fn is_symmetric(&self) -> bool {
        self.friction.is_none_or(|friction| friction.force.factor_by_gap == 0.0)
    }

    /// Entry (p, q) of the tangent; without friction the same number as entry (q, p).
    pub fn tangent(&self, p: usize, q: usize) -> f64 {
        let (row, column) = if p >= q { (p, q) } else { (q, p) };
        let rank_one = self.stiffness * (self.gradient[p] * self.gradient[q]);
        let normal = match self.hessian {
            Some(hessian) => rank_one - self.force * hessian[row * (row + 1) / 2 + column],
            None => rank_one,
        };
        let Some(ActiveFriction { force, slip }) = &self.friction else { return normal };
        let [own, other] = [p, q].map(|p| slip.gradient[p]);
        let second = slip.hessian[row * (row + 1) / 2 + column];
        normal + force.tangent_entry([own, other], second, self.gradient[q])
    }

    /// Writes the rows of the element's node `a`, 3(n+1) entries each: the same numbers as [`tangent`](Self::tangent).
    #[inline(always)]
    pub fn rows<T: Vector>(&self, a: usize, rows: [&mut [f64]; 3]) {
        let freedoms = self.gradient.len();
        let [x, y, z] = rows.map(|row| &mut row[..freedoms]);
        let (stiffness, force) = (self.stiffness, self.force);
        for (i, row) in [&mut *x, &mut *y, &mut *z].into_iter().enumerate() {
            let p = 3 * a + i;
            let own = self.gradient[p];
            match (self.hessian, &self.friction) {
                // Up to the diagonal they are rows of the lower triangle, …
                (Some(hessian), None) => {
                    let seconds = &hessian[packed_row(p)..][..=p];
                    for ((entry, other), second) in row.iter_mut().zip(self.gradient).zip(seconds) {
                        *entry = stiffness * (own * other) - force * second;
                    }
                }
                (None, None) => {
                    for (entry, other) in row.iter_mut().zip(self.gradient) {
                        *entry = stiffness * (own * other);
                    }
                }
                _ => row.iter_mut().enumerate().for_each(|(q, entry)| *entry = self.tangent(p, q)),
            }
        }
        let (Some(hessian), None) = (self.hessian, &self.friction) else { return };
        // … and after it columns.
        let (p, own) = (3 * a, [0, 1, 2].map(|i| self.gradient[3 * a + i]));
        let entry = |i: usize, other: f64, second: f64| stiffness * (own[i] * other) - force * second;
        let second = |row: usize, column: usize| hessian[packed_row(row) + column];
        x[p + 1] = entry(0, own[1], second(p + 1, p));
        x[p + 2] = entry(0, own[2], second(p + 2, p));
        y[p + 2] = entry(1, own[2], second(p + 2, p + 1));
        let mut q = p + 3;
        if T::WIDTH == 4 {
            while q + 4 <= freedoms {
                let mut columns = [T::ZERO; 4];
                for k in 0..4 {
                    columns[k] = self.column(q + k, p);
                }
                let mut targets = [&mut x[q..q + 4], &mut y[q..q + 4], &mut z[q..q + 4]];
                T::store_transposed(&columns, &mut targets, |target| &mut **target);
                q += 4;
            }
        }
        for q in q..freedoms {
            let (other, start) = (self.gradient[q], packed_row(q) + p);
            let seconds = &hessian[start..start + 3];
            x[q] = entry(0, other, seconds[0]);
            y[q] = entry(1, other, seconds[1]);
            z[q] = entry(2, other, seconds[2]);
        }
    }

    /// Entries (q, p) to (q, p + 2) of the tangent without friction, and one more: row q has it, as it belongs to a later node.
    #[inline(always)]
    fn column<T: Vector>(&self, q: usize, p: usize) -> T {
        let own = T::load(self.gradient, p) * T::splat(self.gradient[q]);
        let second = T::load(self.hessian.unwrap_or_default(), packed_row(q) + p);
        T::splat(self.stiffness) * own - T::splat(self.force) * second
    }

    /// Entries (p, 0) … (p, p) of the tangent, and whether all are finite. The same numbers as [`tangent`](Self::tangent).
    pub fn tangent_row(&self, p: usize, row: &mut [f64]) -> bool {
        if self.friction.is_some() {
            let mut is_finite = true;
            for (q, entry) in row.iter_mut().enumerate() {
                *entry = self.tangent(p, q);
                is_finite &= entry.is_finite();
            }
            return is_finite;
        }
        let (stiffness, force, own) = (self.stiffness, self.force, self.gradient[p]);
        let entries = row.iter_mut().zip(&self.gradient[..=p]);
        let mut is_finite = true;
        match self.hessian {
            Some(hessian) => {
                for ((entry, other), second) in entries.zip(&hessian[p * (p + 1) / 2..][..=p]) {
                    *entry = stiffness * (own * other) - force * second;
                    is_finite &= entry.is_finite();
                }
            }
            None => {
                for (entry, other) in entries {
                    *entry = stiffness * (own * other);
                    is_finite &= entry.is_finite();
                }
            }
        }
        is_finite
    }

    /// The error of a tangent that is not finite: its first equation that is not.
    pub fn overflow(&self) -> AssemblyError {
        let freedoms = self.gradient.len();
        let is_sound = |p: usize| (0..freedoms).all(|q| self.tangent(p, q).is_finite());
        let equation = (0..freedoms).find(|&p| !is_sound(p)).unwrap_or(0);
        AssemblyError::Overflow { what: "values", equation }
    }
}
