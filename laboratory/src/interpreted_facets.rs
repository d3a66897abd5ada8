//! The graph of the facet kernels, evaluated as it stands: their second witness, as
//! [`Interpreted`](crate::interpreted::Interpreted) is of the others.

use std::sync::OnceLock;

use diffuse_contact::{ContactPoint, ElementError, FacetElement, FacetPoint, Gap, Mode, SymmetricMatrix};
use diffuse_contact_codegen::interpret::{Interpreter, NodeInputs};
use diffuse_contact_codegen::{ElementKernels, FacetShape};
use diffuse_contact_kernels::support::FacetFigures;

use crate::interpreted::evaluation::Evaluation;
use crate::interpreted::{mode_of, set_vector};

const SHAPES: usize = FacetShape::ALL.len();

/// Evaluates facets by interpreting the graph their kernels are generated from, which is built when it is first needed
/// and kept.
#[derive(Debug, Default)]
pub struct InterpretedFacets {
    elements: [OnceLock<ElementKernels>; SHAPES],
}

impl InterpretedFacets {
    /// Gap and natural coordinates of the foot, the counterpart of
    /// [`Generated::facet_gap`](diffuse_contact::Generated::facet_gap).
    ///
    /// # Errors
    /// As there.
    pub fn gap(&self, element: &FacetElement<'_>, mode: Mode) -> Result<(Gap, FacetPoint), ElementError> {
        element.validate()?;
        let shape = if element.corners.len() == 3 { FacetShape::Triangle } else { FacetShape::Quadrilateral };
        let facet = self.elements[shape as usize].get_or_init(|| ElementKernels::facet(shape));
        let kernel = &facet.kernels[mode_of(mode) as usize];
        let inputs = inputs(element);
        let interpreter = Interpreter::new(&kernel.graph, &inputs);
        let mut evaluation = Evaluation { kernel, interpreter, count: 0 };
        let (gap, foot, normal) =
            (evaluation.scalar("gap"), evaluation.array("foot"), evaluation.array("normal"));
        let natural = evaluation.array("natural");
        let figures = FacetFigures {
            corner_area: evaluation.scalar("corner_area"),
            foot_area: evaluation.scalar("foot_area"),
            foot_residual: evaluation.scalar("foot_residual"),
            foot_iterations: evaluation.scalar("foot_iterations"),
            jacobian_determinant: evaluation.scalar("jacobian_determinant"),
        };
        let mut all = kernel.values.iter().flat_map(|value| &value.components);
        let are_finite = all.all(|&x| evaluation.interpreter.element(x).is_finite());
        ElementError::check(figures.status(are_finite))?;
        let packed = evaluation.values("hessian");
        let size = if packed.is_empty() { 0 } else { element.degrees_of_freedom() };
        let mut hessian = SymmetricMatrix::zeros(size);
        hessian.packed_mut().copy_from_slice(&packed);
        let gradient = evaluation.values("gradient");
        let point = FacetPoint { point: ContactPoint { gap, foot, normal }, natural };
        Ok((Gap { gap, foot, normal, coefficients: Vec::new(), gradient, hessian }, point))
    }
}

fn inputs(element: &FacetElement<'_>) -> NodeInputs {
    let mut inputs = NodeInputs::new(0);
    set_vector(&mut inputs, "slave", element.slave);
    for (k, corner) in element.corners.iter().enumerate() {
        set_vector(&mut inputs, &format!("corners_{}", k + 1), *corner);
    }
    inputs
}
