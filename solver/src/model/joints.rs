//! What a mesh file joins and a model does not, in sentences.

use std::collections::{BTreeMap, HashMap, HashSet};

use diffuse_contact_mesh::UnreadConstraint;
use diffuse_contact_mesh::names::{list, shown};

use super::Part;

/// So many constraints are named.
const NAMED: usize = 3;

/// Constraints of a part's mesh file.
pub(super) fn unread_constraints(part: &str, constraints: &[UnreadConstraint]) -> Option<String> {
    if constraints.is_empty() {
        return None;
    }
    let named: Vec<String> = constraints
        .iter()
        .take(NAMED)
        .map(|UnreadConstraint { keyword, line, .. }| format!("*{keyword} in line {line}"))
        .collect();
    let more = match constraints.len() - named.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    Some(format!(
        "part `{}`: constraints between nodes are not read: {}{more}; what they hold together is loose here",
        shown(part),
        named.join(", ")
    ))
}

/// Elements of a part's mesh file that carry something there.
pub(super) fn unread_elements(part: &str, elements: &BTreeMap<String, usize>) -> Option<String> {
    let kinds = list(elements.iter().map(|(kind, count)| format!("{count} of type {}", shown(kind))));
    (!elements.is_empty()).then(|| {
        format!(
            "part `{}`: elements of its mesh file have no stiffness here: {kinds}; what they carry or hold is missing",
            shown(part)
        )
    })
}

/// Nodes of a part's elements at the very same place.
pub(super) fn seams(name: &str, part: &Part) -> Option<String> {
    let mut places: HashMap<[u64; 3], usize> = HashMap::new();
    let used: HashSet<usize> = part.elements.nodes().iter().copied().collect();
    for &node in &used {
        // 0 and -0 are one place.
        *places.entry(part.nodes[node].map(|x| (x + 0.0).to_bits())).or_default() += 1;
    }
    let doubled: usize = places.into_values().filter(|&count| count > 1).sum();
    (doubled > 0).then(|| {
        format!(
            "part `{}`: {doubled} nodes of its elements lie where others do: nothing but contact joins these elements",
            shown(name)
        )
    })
}

/// Nodes of a mesh file that more than one part of solid elements takes. `parts`: name; file, instance and place; the nodes' numbers in the
/// file.
pub fn shared_nodes<F: PartialEq>(parts: &[(&str, F, Vec<u64>)]) -> Vec<String> {
    let mut sentences = Vec::new();
    for (k, (name, file, nodes)) in parts.iter().enumerate() {
        let nodes: HashSet<u64> = nodes.iter().copied().collect();
        for (other, _, others) in parts[k + 1..].iter().filter(|(_, of, _)| of == file) {
            let count = others.iter().filter(|node| nodes.contains(node)).count();
            if count > 0 {
                sentences.push(format!(
                    "parts `{}` and `{}` share {count} nodes in their mesh file, and none here: only contact joins them. One part may \
                     have several materials",
                    shown(name),
                    shown(other)
                ));
            }
        }
    }
    sentences
}
