//! A part of a matrix that is there by its products alone.

/// A matrix over all nodes that is never assembled; with friction it is not symmetric. A linear system adds it to an assembled one, which alone is preconditioned.
pub trait Operator {
    /// y ← y + A x
    ///
    /// # Errors
    /// An entry of x or of y, three for a node, that is not finite, and its value. What y holds is then unspecified.
    fn add_product(&self, x: &[[f64; 3]], y: &mut [[f64; 3]]) -> Result<(), (usize, f64)>;

    /// Memory, bytes.
    fn bytes(&self) -> usize;
}
