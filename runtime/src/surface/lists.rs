//! Lists of the nodes that a slave may need whose closest facet is known.

use rayon::prelude::*;

use super::sheets::{CHUNK, Found, Listed, Sheets};
use super::topology::NONE;
use crate::MaterialDomain;
use crate::vector::Vector3;

/// The list of a facet holds nodes whose domains end this far from it, over the domain: a slave's place may lie as far off its
/// closest facet.
const MARGIN: f64 = 0.3;

impl Sheets<'_> {
    /// The lists of these facets, and those of them whose list may depend on what is not there.
    pub fn lists(&self, domains: &[MaterialDomain], facets: &[u32]) -> (Vec<Vec<Listed>>, Vec<u32>) {
        let extents: Vec<f64> = domains.par_iter().map(MaterialDomain::extent).collect();
        let lists: Vec<(Vec<Listed>, bool)> = facets
            .par_iter()
            .with_min_len(CHUNK)
            .map_init(Found::default, |found, &facet| {
                found.is_open = false;
                (list(self, (domains, &extents), facet, found), found.is_open)
            })
            .collect();
        let open = facets.iter().zip(&lists).filter(|(_, list)| list.1).map(|(facet, _)| *facet).collect();
        (lists.into_iter().map(|list| list.0).collect(), open)
    }
}

/// The nodes of the facet's sheet whose domains, with a margin, reach it, and their images.
pub(super) fn list(
    sheets: &Sheets<'_>,
    (domains, extents): (&[MaterialDomain], &[f64]),
    facet: u32,
    found: &mut Found,
) -> Vec<Listed> {
    let symmetry = sheets.symmetry;
    let shape = sheets.index.shape(facet);
    let corners = shape.corners();
    let middle = shape.middle();
    let reaches = |domain: &MaterialDomain| {
        let reach = corners
            .iter()
            .map(|&corner| domain.length(corner - middle))
            .fold(1.0 + MARGIN, |reach, x| reach.max(1.0 + MARGIN + x));
        domain.metric[0] > 0.0 && domain.length(Vector3::from(domain.position) - middle) < reach
    };
    // A domain that reaches the facet from afar is long: walks go on while they meet such.
    let mut reach = shape.extent();
    loop {
        sheets.find(found, (facet, middle.into()), reach);
        let longest = found.nodes.iter().map(|&node| extents[node as usize]).fold(0.0, f64::max);
        let needed = (1.0 + MARGIN) * longest + shape.extent();
        if needed <= reach {
            break;
        }
        reach = needed;
    }
    let mut all = Vec::new();
    for &node in &found.nodes {
        let domain = &domains[node as usize];
        if reaches(domain) {
            all.push(Listed { node, image: NONE });
        }
        symmetry.images_near(domain.position, middle.into(), reach, |image, _| {
            if reaches(&symmetry.domain_of(image, domain)) {
                all.push(Listed { node, image });
            }
        });
    }
    all
}
