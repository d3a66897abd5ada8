//! Which displacements are unknown.

/// Numbers the free (node, axis): node by node, x before y before z, the prescribed ones left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Equations {
    /// Equation of each (node, axis), [`PRESCRIBED`] if there is none.
    numbers: Vec<[u32; 3]>,
    /// (node, axis) of each equation.
    places: Vec<(u32, u8)>,
}

/// Not an equation.
const PRESCRIBED: u32 = u32::MAX;

impl Equations {
    /// All but those `prescribed`, by node and axis.
    ///
    /// # Panics
    /// If there are more than 32-bit indices can name.
    pub fn new(prescribed: &[[bool; 3]]) -> Self {
        assert!(prescribed.len() < (PRESCRIBED / 3) as usize, "more equations than 32-bit indices can name");
        let mut places = Vec::new();
        let numbers = prescribed
            .iter()
            .enumerate()
            .map(|(node, axes)| {
                let mut numbers = [PRESCRIBED; 3];
                for axis in 0..3 {
                    if !axes[axis] {
                        numbers[axis] = places.len() as u32;
                        places.push((node as u32, axis as u8));
                    }
                }
                numbers
            })
            .collect();
        Self { numbers, places }
    }

    /// Number of nodes.
    pub fn nodes(&self) -> usize {
        self.numbers.len()
    }

    /// Number of equations.
    pub fn len(&self) -> usize {
        self.places.len()
    }

    /// Whether everything is prescribed.
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// The equation of a (node, axis); `None` if it is prescribed.
    pub fn number(&self, node: usize, axis: usize) -> Option<usize> {
        let number = self.numbers[node][axis];
        (number != PRESCRIBED).then_some(number as usize)
    }

    /// The (node, axis) of an equation.
    pub fn place(&self, equation: usize) -> (usize, usize) {
        let (node, axis) = self.places[equation];
        (node as usize, axis as usize)
    }

    /// Whether each (node, axis) is free.
    pub(super) fn free(&self) -> Vec<[bool; 3]> {
        self.numbers.iter().map(|axes| axes.map(|number| number != PRESCRIBED)).collect()
    }

    /// Sets to 0 what is prescribed.
    pub(super) fn clear_prescribed(&self, vector: &mut [[f64; 3]]) {
        for (numbers, values) in self.numbers.iter().zip(vector) {
            for axis in 0..3 {
                if numbers[axis] == PRESCRIBED {
                    values[axis] = 0.0;
                }
            }
        }
    }

    /// The free part of a vector over all nodes.
    pub(super) fn gather(&self, vector: &[[f64; 3]], free: &mut Vec<f64>) {
        free.clear();
        free.extend(self.places.iter().map(|&(node, axis)| vector[node as usize][axis as usize]));
    }

    /// Over all nodes the vector whose free part is `free`, 0 elsewhere.
    pub(super) fn scatter(&self, free: &[f64], vector: &mut Vec<[f64; 3]>) {
        vector.clear();
        vector.resize(self.nodes(), [0.0; 3]);
        for (&(node, axis), &value) in self.places.iter().zip(free) {
            vector[node as usize][axis as usize] = value;
        }
    }
}
