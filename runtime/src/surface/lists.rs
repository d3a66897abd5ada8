//! Lists of the nodes that a slave may need whose closest facet is known.

use rayon::prelude::*;

use super::Shape;
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

/// Of lists those nodes whose domains, which have shrunk since, still reach the facet.
pub(crate) fn still_listed(
    sheets: &Sheets<'_>,
    domains: &[MaterialDomain],
    facets: &[u32],
    lists: &mut [Vec<Listed>],
) {
    facets.par_iter().zip(lists).with_min_len(CHUNK).for_each(|(&facet, list)| {
        let shape = sheets.index.shape(facet);
        let reaches = reaching(&shape);
        list.retain(|own| reaches(&sheets.domain_of(domains, own)));
    });
}

/// Whether a domain, with a margin, reaches a facet.
fn reaching(shape: &Shape) -> impl Fn(&MaterialDomain) -> bool {
    let middle = shape.middle();
    move |domain| {
        let corners = shape.corners().iter();
        let reach = corners
            .map(|&corner| domain.length(corner - middle))
            .fold(1.0 + MARGIN, |reach, x| reach.max(1.0 + MARGIN + x));
        domain.metric[0] > 0.0 && domain.length(Vector3::from(domain.position) - middle) < reach
    }
}

/// The nodes of the facet's sheet whose domains, with a margin, reach it, and their images.
fn list(
    sheets: &Sheets<'_>,
    (domains, extents): (&[MaterialDomain], &[f64]),
    facet: u32,
    found: &mut Found,
) -> Vec<Listed> {
    let Sheets { index, nodes, symmetry, .. } = *sheets;
    let shape = index.shape(facet);
    let middle = shape.middle();
    let reaches = reaching(&shape);
    let needed = |longest: f64| (1.0 + MARGIN) * longest + shape.extent();
    let longest = |longest: f64, node: u32| longest.max(extents[node as usize]);
    // A domain that reaches the facet from afar is long: walks go on while they meet such.
    let mut reach = needed(nodes.of_facet(index.surface(), facet).iter().copied().fold(0.0, longest));
    loop {
        sheets.find(found, (facet, middle.into()), reach);
        let all = needed(found.nodes.iter().copied().fold(0.0, longest));
        if all <= reach {
            break;
        }
        reach = all;
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
