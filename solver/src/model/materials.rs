//! Which material each element of a part has.

use diffuse_contact_mesh::names::{closest_first, nearest};

use super::{Body, ModelError, Part};
use crate::material::Material;

/// What a part is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Materials {
    /// Nothing: it is rigid.
    None,
    /// One material.
    One(Material),
    /// One for each of these element sets, which hold every element once.
    BySet(Vec<(String, Material)>),
}

impl From<Option<Material>> for Materials {
    fn from(material: Option<Material>) -> Self {
        material.map_or(Self::None, Self::One)
    }
}

/// The bodies of a part whose nodes are numbered from `first` on.
pub(super) fn bodies(
    name: &str,
    part: &Part,
    materials: &Materials,
    first: usize,
) -> Result<Vec<Body>, ModelError> {
    let is_rigid = part.elements.is_empty();
    let body = |name: &str, part_name: &str, elements: &[usize], material: Material| Body {
        part: part_name.to_owned(),
        name: name.to_owned(),
        elements: part.elements.chosen(elements).renumbered(|node| node + first),
        labels: elements.iter().filter_map(|&k| part.labels.get(k).copied()).collect(),
        material,
    };
    match materials {
        Materials::None if is_rigid => Ok(Vec::new()),
        Materials::None => Err(ModelError::NoMaterial { part: name.into() }),
        _ if is_rigid => Err(ModelError::RigidMaterial { part: name.into() }),
        Materials::One(material) => {
            let all: Vec<usize> = (0..part.elements.len()).collect();
            Ok(vec![body(name, name, &all, *material)])
        }
        Materials::BySet(sets) => {
            let mut owners: Vec<Option<&str>> = vec![None; part.elements.len()];
            let label = |element: usize| part.labels.get(element).copied();
            let mut bodies = Vec::with_capacity(sets.len());
            for (set, material) in sets {
                let (spelling, elements) = find(name, part, set)?;
                for &element in elements {
                    if let Some(other) = owners[element].replace(set) {
                        let sets = [other.to_owned(), set.clone()];
                        return Err(ModelError::TwoMaterials {
                            part: name.into(),
                            element,
                            label: label(element),
                            sets,
                        });
                    }
                }
                bodies.push(body(&format!("{name}.{spelling}"), name, elements, *material));
            }
            match owners.iter().position(Option::is_none) {
                None => Ok(bodies),
                Some(element) => Err(ModelError::ElementWithoutMaterial {
                    part: name.into(),
                    element,
                    label: label(element),
                    count: owners.iter().filter(|owner| owner.is_none()).count(),
                }),
            }
        }
    }
}

/// The element set of this name or, failing that, the only one whose name differs by letter case alone, as the file spells it.
fn find<'a>(name: &str, part: &'a Part, set: &str) -> Result<(&'a str, &'a [usize]), ModelError> {
    let sets = &part.element_sets;
    let shown = |(spelling, elements): (&'a String, &'a Vec<usize>)| (spelling.as_str(), &elements[..]);
    if let Some(found) = sets.get_key_value(set) {
        return Ok(shown(found));
    }
    let mut alike = sets.iter().filter(|(spelling, _)| spelling.to_lowercase() == set.to_lowercase());
    match (alike.next(), alike.next()) {
        (Some(found), None) => Ok(shown(found)),
        _ => Err(ModelError::NoElementSet {
            part: name.into(),
            set: set.into(),
            nearest: nearest(set, sets.keys().map(String::as_str)).map(str::to_owned),
            known: closest_first(set, sets.keys().map(String::as_str))
                .into_iter()
                .map(str::to_owned)
                .collect(),
        }),
    }
}
