//! Reads Gmsh's MSH format, version 4.1, ASCII or binary of either byte order.
//!
//! Of the sections, `$PhysicalNames`, `$Entities`, `$Nodes` and `$Elements` are read; partitioned meshes are
//! refused; all others are skipped. The format is described in the Gmsh reference manual, "MSH file format".

mod source;

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::path::Path;

use crate::builder::{Builder, MOST_MEMBERS};
use crate::element::{Element, ElementKind, Facet, MOST_NODES};
use crate::error::{Fault, MeshError, Problem};
use crate::mesh::{Mesh, Unread};
use source::{Encoding, Source};

/// Reads a mesh from the content of an MSH file.
pub(crate) fn read(bytes: &[u8], path: &Path) -> Result<Mesh, MeshError> {
    let mut source = Source::new(bytes);
    let mesh = File::read(&mut source).and_then(File::into_mesh);
    mesh.map_err(|fault| match source.encoding {
        Encoding::Ascii => fault.in_text(path, bytes),
        Encoding::LittleEndian | Encoding::BigEndian => fault.in_binary(path),
    })
}

/// A geometric entity: its dimension and its tag.
type Entity = (i32, i32);

/// Element sets and surfaces by name.
type Sets = (BTreeMap<String, Vec<usize>>, BTreeMap<String, Vec<Facet>>);

/// The sections of a file.
#[derive(Default)]
struct File {
    /// Names of the physical groups, by dimension and tag.
    names: HashMap<(i32, i32), String>,
    /// The physical groups an entity belongs to; a negative tag reverses the entity.
    groups: HashMap<Entity, Vec<i32>>,
    builder: Builder,
    /// The byte at which the entities begin.
    entities_at: usize,
    /// The entity of every element.
    entities: Vec<Entity>,
}

impl File {
    fn read(source: &mut Source) -> Result<Self, Fault> {
        read_format(source)?;
        let mut file = File::default();
        while let Some((at, heading)) = source.line() {
            match heading {
                b"$PhysicalNames" => file.read_physical_names(source)?,
                b"$Entities" => file.read_entities(source)?,
                b"$Nodes" => file.read_nodes(source)?,
                b"$Elements" => file.read_elements(source)?,
                b"$PartitionedEntities" => {
                    let feature = "a partitioned mesh ($PartitionedEntities)";
                    let advice = "save it unpartitioned (in Gmsh: Mesh, Unpartition)";
                    return Err(Fault::unsupported(at, feature, advice));
                }
                _ => match heading.strip_prefix(b"$").map(std::str::from_utf8) {
                    Some(Ok(section)) if !section.starts_with("End") => source.skip_section(section)?,
                    _ => return Err(Fault::unexpected(at, "a section heading such as $Nodes", heading)),
                },
            }
        }
        Ok(file)
    }

    /// This section is text even in a binary file.
    fn read_physical_names(&mut self, source: &mut Source) -> Result<(), Fault> {
        let (at, line) = source.expected_line("the number of physical names")?;
        let count: u64 = std::str::from_utf8(line)
            .ok()
            .and_then(|text| text.parse().ok())
            .ok_or_else(|| Fault::unexpected(at, "the number of physical names", line))?;
        for _ in 0..count {
            const FORM: &str = "a physical name: dimension, tag, \"name\"";
            let (at, line) = source.expected_line(FORM)?;
            let (dimension, tag, name) =
                parse_physical_name(line).ok_or_else(|| Fault::unexpected(at, FORM, line))?;
            self.names.insert((dimension, tag), name);
        }
        source.end_of("PhysicalNames")
    }

    fn read_entities(&mut self, source: &mut Source) -> Result<(), Fault> {
        self.entities_at = source.at();
        let mut counts = [0; 4];
        for count in &mut counts {
            *count = source.size("a number of entities")?;
        }
        for (dimension, count) in (0..).zip(counts) {
            source.check_announced(count, 4, "entities")?;
            for _ in 0..count {
                let tag = source.int("an entity's tag")?;
                let extents = if dimension == 0 { 3 } else { 6 };
                for _ in 0..extents {
                    source.real("a coordinate of an entity")?;
                }
                let groups = read_ints(source, "the tag of a physical group")?;
                if dimension > 0 {
                    read_ints(source, "the tag of a bounding entity")?;
                }
                self.groups.insert((dimension, tag), groups);
            }
        }
        source.end_of("Entities")
    }

    fn read_nodes(&mut self, source: &mut Source) -> Result<(), Fault> {
        let header = source.at();
        let blocks = source.size("the number of node blocks")?;
        let declared = source.size("the number of nodes")?;
        source.size("the smallest node tag")?;
        source.size("the largest node tag")?;
        let mut found = 0;
        for _ in 0..blocks {
            let at = source.at();
            let dimension = source.int("the dimension of a node block's entity")?;
            let dimension = u32::try_from(dimension)
                .ok()
                .filter(|&dimension| dimension <= 3)
                .ok_or_else(|| Fault::unexpected(at, "a dimension from 0 to 3", dimension.to_string()))?;
            source.int("the tag of a node block's entity")?;
            let at = source.at();
            let parameters = match source.int("whether the nodes have parameters (0 or 1)")? {
                0 => 0,
                1 => dimension,
                other => {
                    return Err(Fault::unexpected(at, "0 or 1 (parametric nodes)", other.to_string()));
                }
            };
            let count = source.size("the number of nodes of a block")?;
            source.check_announced(count, 32, "nodes")?;
            let mut tags = Vec::new();
            for _ in 0..count {
                tags.push((source.at(), source.size("a node tag")?));
            }
            for (tag_at, tag) in tags {
                let at = source.at();
                let mut coordinates = [0.0; 3];
                for coordinate in &mut coordinates {
                    *coordinate = source.real("a coordinate of a node")?;
                }
                for _ in 0..parameters {
                    source.real("a parameter of a node")?;
                }
                self.builder.add_node((tag, tag_at), (coordinates, at))?;
            }
            found += count;
        }
        check_count("nodes", declared, found, header)?;
        source.end_of("Nodes")
    }

    fn read_elements(&mut self, source: &mut Source) -> Result<(), Fault> {
        let header = source.at();
        let blocks = source.size("the number of element blocks")?;
        let declared = source.size("the number of elements")?;
        source.size("the smallest element tag")?;
        source.size("the largest element tag")?;
        let mut found = 0;
        for _ in 0..blocks {
            let dimension = source.int("the dimension of an element block's entity")?;
            let entity = source.int("the tag of an element block's entity")?;
            let at = source.at();
            let (kind, order) = element_kind(source.int("an element type")?)
                .map_err(|name| Fault::new(at, Problem::UnsupportedElement { name }))?;
            let count = source.size("the number of elements of a block")?;
            source.check_announced(count, 8 * (1 + kind.node_count() as u64), "elements")?;
            for _ in 0..count {
                let at = source.at();
                let tag = source.size("an element tag")?;
                let mut found = [0; MOST_NODES];
                for node in &mut found[..kind.node_count()] {
                    *node = source.size("the tag of an element's node")?;
                }
                let mut nodes = found;
                for (node, &place) in nodes.iter_mut().zip(order.unwrap_or_default()) {
                    *node = found[place];
                }
                self.builder.add_element(kind, tag, nodes, at)?;
                self.entities.push((dimension, entity));
            }
            found += count;
        }
        check_count("elements", declared, found, header)?;
        source.end_of("Elements")
    }

    fn into_mesh(self) -> Result<Mesh, Fault> {
        let elements = self.builder.resolved_elements()?;
        let (element_sets, surfaces) = self.sets(&elements)?;
        let (nodes, node_tags) = self.builder.into_nodes();
        Ok(Mesh {
            nodes,
            node_tags,
            elements,
            node_sets: BTreeMap::new(),
            element_sets,
            surfaces,
            unread: Unread::default(),
            stiff: Vec::new(),
            constraints: Vec::new(),
        })
    }

    /// The physical groups as element sets, and those that reverse some facet also as surfaces.
    fn sets(&self, elements: &[Element]) -> Result<Sets, Fault> {
        let mut members: HashMap<Entity, Vec<usize>> = HashMap::new();
        for (index, &entity) in self.entities.iter().enumerate() {
            members.entry(entity).or_default().push(index);
        }
        let mut sets: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        let mut reversed: BTreeMap<String, BTreeSet<usize>> = BTreeMap::new();
        let mut room = MOST_MEMBERS;
        for (entity, members) in &members {
            for group in self.groups.get(entity).into_iter().flatten() {
                room = room.checked_sub(members.len()).ok_or_else(|| {
                    Fault::new(
                        self.entities_at,
                        Problem::SetsTooLarge { what: "elements", limit: MOST_MEMBERS },
                    )
                })?;
                let name = self.group_name(entity.0, group.saturating_abs());
                if *group < 0 && entity.0 == 2 {
                    reversed.entry(name.clone()).or_default().extend(members);
                }
                sets.entry(name).or_default().extend(members);
            }
        }
        for set in sets.values_mut() {
            set.sort_unstable();
            set.dedup();
        }
        let surface = |(name, reversed): (String, BTreeSet<usize>)| {
            let facets = sets[&name].iter().flat_map(|index| {
                let is_reversed = reversed.contains(index);
                let facets = elements[*index].facets().into_iter();
                facets.map(move |facet| if is_reversed { facet.reversed() } else { facet })
            });
            let facets = facets.collect();
            (name, facets)
        };
        let surfaces = reversed.into_iter().map(surface).collect();
        Ok((sets, surfaces))
    }

    fn group_name(&self, dimension: i32, tag: i32) -> String {
        let word = match dimension {
            0 => "point",
            1 => "curve",
            2 => "surface",
            _ => "volume",
        };
        self.names.get(&(dimension, tag)).cloned().unwrap_or_else(|| format!("{word} {tag}"))
    }
}

fn read_format(source: &mut Source) -> Result<(), Fault> {
    const FORM: &str = "the version, the file type (0 or 1) and the size of size_t, such as 4.1 0 8";
    let (at, heading) = source.expected_line("$MeshFormat")?;
    if heading != b"$MeshFormat" {
        return Err(Fault::unexpected(at, "$MeshFormat", heading));
    }
    let (at, line) = source.expected_line(FORM)?;
    let text = std::str::from_utf8(line).map_err(|_| Fault::unexpected(at, FORM, line))?;
    let fields: Vec<&str> = text.split_ascii_whitespace().collect();
    let [version, file_type, size] = fields[..] else {
        return Err(Fault::unexpected(at, FORM, line));
    };
    if version != "4.1" {
        return Err(Fault::new(at, Problem::UnsupportedVersion { version: version.into() }));
    }
    match (file_type, size) {
        ("0", _) => {}
        ("1", "8") => source.byte_order()?,
        ("1", _) => {
            let advice = "save the mesh on a 64-bit machine or as ASCII";
            return Err(Fault::unsupported(at, format!("a size_t of {size} bytes"), advice));
        }
        _ => return Err(Fault::unexpected(at, FORM, line)),
    }
    source.end_of("MeshFormat")
}

/// `2 7 "a name"`.
fn parse_physical_name(line: &[u8]) -> Option<(i32, i32, String)> {
    let text = std::str::from_utf8(line).ok()?;
    let (numbers, name) = text.strip_suffix('"')?.split_once('"')?;
    let mut numbers = numbers.split_ascii_whitespace();
    let dimension = numbers.next()?.parse().ok()?;
    let tag = numbers.next()?.parse().ok()?;
    numbers.next().is_none().then(|| (dimension, tag, name.to_string()))
}

/// A count and as many `int`s.
fn read_ints(source: &mut Source, what: &str) -> Result<Vec<i32>, Fault> {
    let count = source.size("a number of tags")?;
    source.check_announced(count, 4, "tags")?;
    (0..count).map(|_| source.int(what)).collect()
}

fn check_count(what: &'static str, declared: u64, found: u64, at: usize) -> Result<(), Fault> {
    if declared == found {
        Ok(())
    } else {
        Err(Fault::new(at, Problem::CountMismatch { what, declared, found }))
    }
}

/// The kind of a Gmsh element type with the place of each of its nodes in Gmsh's order, if that is another than ours; or the name of a
/// type that is not supported.
fn element_kind(number: i32) -> Result<(ElementKind, Option<&'static [usize]>), String> {
    let name = match number {
        15 => return Ok((ElementKind::Point1, None)),
        1 => return Ok((ElementKind::Line2, None)),
        2 => return Ok((ElementKind::Triangle3, None)),
        3 => return Ok((ElementKind::Quadrilateral4, None)),
        4 => return Ok((ElementKind::Tetrahedron4, None)),
        5 => return Ok((ElementKind::Hexahedron8, None)),
        6 => return Ok((ElementKind::Wedge6, None)),
        8 => return Ok((ElementKind::Line3, None)),
        9 => return Ok((ElementKind::Triangle6, None)),
        10 => return Ok((ElementKind::Quadrilateral9, None)),
        11 => return Ok((ElementKind::Tetrahedron10, Some(&TETRAHEDRON10))),
        12 => return Ok((ElementKind::Hexahedron27, Some(&HEXAHEDRON27))),
        16 => return Ok((ElementKind::Quadrilateral8, None)),
        17 => return Ok((ElementKind::Hexahedron20, Some(HEXAHEDRON27.split_at(20).0))),
        18 => return Ok((ElementKind::Wedge15, Some(&WEDGE15))),
        7 => "5-node pyramid",
        13 => "18-node second-order prism",
        14 => "14-node second-order pyramid",
        19 => "13-node second-order pyramid",
        20..=31 | 92 | 93 => "higher-order element",
        _ => "unknown",
    };
    Err(format!("{number} ({name})"))
}

/// Where Gmsh has the nodes of a kind, in our order (Gmsh reference manual, "Node ordering").
const TETRAHEDRON10: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8];
const WEDGE15: [usize; 15] = [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11];
/// The first 20 are those of the hexahedron with as many.
const HEXAHEDRON27: [usize; 27] =
    [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25, 26];
