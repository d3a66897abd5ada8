//! Sparse matrices in node blocks.
