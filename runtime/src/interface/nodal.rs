//! The domains of influence of a master surface's nodes, as an interface keeps them.

use super::{ContactElement, InterfaceError, InterfaceOptions};
use crate::MaterialDomain;
use crate::Point;
use crate::neighbourhood::NeighbourRule;
use crate::surface::window::Extents;
use crate::surface::{Creases, NONE, NodalDomains, SurfaceIndex, Symmetry, SymmetryPlane};

/// Nodal domains, the sheets they belong to, and what they were found from.
#[derive(Clone, Debug)]
pub struct Nodal {
    pub domains: NodalDomains,
    pub symmetry: Symmetry,
    /// Where sheets end.
    pub creases: Creases,
    /// Of the surface where its planes of symmetry were given.
    pub extents: Extents,
}

impl Nodal {
    /// With the surface as it is, if the options ask for domains.
    ///
    /// # Errors
    /// [`InterfaceError::Surface`] for planes that cannot be planes of symmetry.
    pub fn new(
        index: &SurfaceIndex<'_>,
        options: &InterfaceOptions,
        planes: &[SymmetryPlane],
    ) -> Result<Option<Self>, InterfaceError> {
        let ContactElement::Diffuse { weight, search, .. } = options.element else { return Ok(None) };
        if search.rule != NeighbourRule::Domains {
            return Ok(None);
        }
        let extents = Extents::of(index);
        check_model(index, planes)?;
        let symmetry = Symmetry::of_surface(planes, &extents)?;
        let creases = Creases::new(index, options.feature_angle_degrees.to_radians(), &symmetry);
        let domains = NodalDomains::new(index, &creases, &symmetry, weight, search.basis);
        Ok(Some(Self { domains, symmetry, creases, extents }))
    }

    /// That of a sheet node, or of its image with this number.
    pub fn domain(&self, node: u32, image: u32) -> MaterialDomain {
        let domain = *self.domains.domain(node);
        if image == NONE { domain } else { self.symmetry.domain_of(image, &domain) }
    }
}

/// The planes of a surface without domains, which has no images in them.
pub fn planes_of(index: &SurfaceIndex<'_>, planes: &[SymmetryPlane]) -> Result<Symmetry, InterfaceError> {
    if planes.is_empty() {
        return Ok(Symmetry::default());
    }
    Ok(Symmetry::of_planes(planes, Extents::of(index).facet)?)
}

/// Refuses what cannot be planes of symmetry of a surface.
///
/// # Errors
/// [`InterfaceError::Surface`].
pub fn check_model(index: &SurfaceIndex<'_>, planes: &[SymmetryPlane]) -> Result<(), InterfaceError> {
    if !planes.is_empty() {
        Symmetry::check_model(planes, index.positions(), &Extents::at_nodes(index))?;
    }
    Ok(())
}

/// Refuses what cannot be planes of symmetry of a surface, or has slaves behind it.
///
/// # Errors
/// [`InterfaceError::Surface`], [`InterfaceError::SlaveBehindSymmetry`].
pub fn check_planes(
    index: &SurfaceIndex<'_>,
    planes: &[SymmetryPlane],
    slaves: &[usize],
    positions: &[Point],
) -> Result<(), InterfaceError> {
    if planes.is_empty() {
        return Ok(());
    }
    let (nodes, extents) = (index.positions(), Extents::at_nodes(index));
    Symmetry::check_model(planes, nodes, &extents)?;
    let points = slaves.iter().map(|&node| positions[node]);
    match Symmetry::farthest_behind(planes, nodes, &extents, points)? {
        None => Ok(()),
        Some((plane, place, distance)) => {
            Err(InterfaceError::SlaveBehindSymmetry { node: slaves[place], plane, distance })
        }
    }
}
