//! Parts and their instances: which one is read, where it lies, and what else the assembly holds.

use std::collections::HashSet;

use super::lines::{Data, Keyword, Lines};
use super::{SetKind, parse_real};
use crate::error::{Fault, Problem};

/// The one instance, with its part, that is read; a file without instances may have one part.
#[derive(Default)]
pub(super) struct Choice {
    part: Option<String>,
    instance: Option<String>,
    /// In upper case: each member of each set asks for them.
    others: HashSet<String>,
}

fn same(one: Option<&str>, other: &str) -> bool {
    one.is_some_and(|one| one.eq_ignore_ascii_case(other))
}

impl Choice {
    /// Looks at a file's keywords. `wanted`: name of the instance, which has to be given if there are several.
    pub fn of(bytes: &[u8], wanted: Option<&str>) -> Result<Self, Fault> {
        let mut lines = Lines::new(bytes);
        let (mut parts, mut instances) = (Vec::<Keyword>::new(), Vec::<Keyword>::new());
        lines.skip_data();
        while let Some(keyword) = lines.keyword()? {
            match keyword.name.as_str() {
                "PART" => parts.push(keyword),
                "INSTANCE" => instances.push(keyword.spelled_out()?),
                _ => {}
            }
            lines.skip_data();
        }
        let available = instances
            .iter()
            .map(|keyword| Ok(keyword.required("NAME")?.to_string()))
            .collect::<Result<Vec<_>, Fault>>()?;
        let chosen = match (wanted, &instances[..]) {
            (Some(name), _) => match available.iter().position(|other| other.eq_ignore_ascii_case(name)) {
                Some(k) => &instances[k],
                None => {
                    let at = instances.first().map_or(0, |keyword| keyword.at);
                    return Err(Fault::new(at, Problem::UnknownInstance { name: name.into(), available }));
                }
            },
            (None, [_, second, ..]) => {
                return Err(Fault::new(second.at, Problem::SeveralInstances { available }));
            }
            (None, [only]) => only,
            (None, []) => match &parts[..] {
                [_, second, ..] => {
                    let advice =
                        "an assembly has to say which of the parts there are in the model, and where";
                    return Err(super::refused(second, advice));
                }
                [only] => {
                    let part = Some(only.required("NAME")?.to_string());
                    return Ok(Self { part, ..Self::default() });
                }
                [] => return Ok(Self::default()),
            },
        };
        let name = chosen.required("NAME")?;
        let part = chosen.value("PART").map(String::from);
        if let Some(part) = &part
            && !parts.iter().any(|keyword| same(keyword.value("NAME"), part))
        {
            let member = format!("part {part:?}");
            return Err(Fault::new(chosen.at, Problem::MissingMember { set: name.into(), member }));
        }
        let instance = Some(name.to_string());
        let others = available.into_iter().filter(|other| !same(instance.as_deref(), other));
        let others = others.map(|other| other.to_ascii_uppercase()).collect();
        Ok(Self { part, instance, others })
    }

    pub fn is_part(&self, name: &str) -> bool {
        same(self.part.as_deref(), name)
    }

    pub fn is_instance(&self, name: &str) -> bool {
        same(self.instance.as_deref(), name)
    }

    /// Whether there is an instance of this name that is not read.
    pub fn is_other(&self, name: &str) -> bool {
        self.others.contains(&name.to_ascii_uppercase())
    }

    /// A name for what belongs to the part.
    pub fn owner(self) -> String {
        self.instance.or(self.part).unwrap_or_default()
    }
}

/// Nodes and elements of the assembly itself, such as reference points, masses and connectors: nothing of the instance. Sets may
/// refer to them.
#[derive(Default)]
pub(super) struct Bystanders {
    nodes: HashSet<u64>,
    elements: HashSet<u64>,
}

impl Bystanders {
    pub fn of(&self, kind: SetKind) -> &HashSet<u64> {
        match kind {
            SetKind::Node => &self.nodes,
            SetKind::Element => &self.elements,
        }
    }

    pub fn insert(&mut self, kind: SetKind, tag: u64) {
        match kind {
            SetKind::Node => self.nodes.insert(tag),
            SetKind::Element => self.elements.insert(tag),
        };
    }
}

/// Where an instance lies: its part is translated, then rotated about the axis from one point to another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Placement {
    at: usize,
    translation: [f64; 3],
    rotation: Option<Turn>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Turn {
    point: [f64; 3],
    /// Of length 1.
    axis: [f64; 3],
    /// Radians, by the right-hand rule.
    angle: f64,
}

impl Placement {
    /// The data lines below `*INSTANCE`: none, a translation, or a translation and a rotation.
    pub fn read(lines: &mut Lines) -> Result<Self, Fault> {
        let mut placement = Self::default();
        let Some(first) = lines.data() else { return Ok(placement) };
        (placement.at, placement.translation) = (first.at, numbers(&first, "a translation: x, y, z")?);
        let Some(second) = lines.data() else { return Ok(placement) };
        const FORM: &str = "a rotation: two different points of its axis, and degrees";
        let [ax, ay, az, bx, by, bz, degrees] = numbers(&second, FORM)?;
        let along = [bx - ax, by - ay, bz - az];
        let length = along.iter().map(|x| x * x).sum::<f64>().sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return Err(Fault::unexpected(second.at, FORM, second.fields.join(", ")));
        }
        let axis = along.map(|x| x / length);
        placement.rotation = Some(Turn { point: [ax, ay, az], axis, angle: degrees.to_radians() });
        Ok(placement)
    }

    /// Moves nodes to where they are in the assembly; `tags` are theirs.
    pub fn apply(&self, nodes: &mut [[f64; 3]], tags: &[u64]) -> Result<(), Fault> {
        if *self == (Self { at: self.at, ..Self::default() }) {
            return Ok(());
        }
        for (node, &tag) in nodes.iter_mut().zip(tags) {
            *node = self.placed(*node);
            for (axis, value) in ['x', 'y', 'z'].into_iter().zip(*node) {
                if !value.is_finite() {
                    return Err(Fault::new(self.at, Problem::NonFiniteCoordinate { tag, axis, value }));
                }
            }
        }
        Ok(())
    }

    fn placed(&self, node: [f64; 3]) -> [f64; 3] {
        let moved = [0, 1, 2].map(|k| node[k] + self.translation[k]);
        let Some(Turn { point, axis, angle }) = self.rotation else { return moved };
        let from = [0, 1, 2].map(|k| moved[k] - point[k]);
        let across = [
            axis[1] * from[2] - axis[2] * from[1],
            axis[2] * from[0] - axis[0] * from[2],
            axis[0] * from[1] - axis[1] * from[0],
        ];
        let along: f64 = (0..3).map(|k| axis[k] * from[k]).sum();
        let (sin, cos) = angle.sin_cos();
        [0, 1, 2].map(|k| point[k] + cos * from[k] + sin * across[k] + (1.0 - cos) * along * axis[k])
    }
}

/// The numbers of a data line; those that are left out are 0.
fn numbers<const N: usize>(data: &Data, form: &str) -> Result<[f64; N], Fault> {
    let fields = data.fields.iter().rposition(|field| !field.is_empty()).map_or(0, |last| last + 1);
    if fields > N {
        return Err(Fault::unexpected(data.at, form, data.fields.join(", ")));
    }
    let mut numbers = [0.0; N];
    for (number, field) in numbers.iter_mut().zip(&data.fields).filter(|(_, field)| !field.is_empty()) {
        *number = parse_real(field, data.at, form)?;
    }
    Ok(numbers)
}
