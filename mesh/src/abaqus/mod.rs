//! Reads the mesh of an Abaqus input file: nodes, elements, sets and surfaces.
//!
//! The file is flat, or has parts and an assembly of instances, of which one is read. Keywords that create or move nodes
//! and are not supported are refused, and so is what is near to a keyword of a mesh; all others (materials, steps, ...) are skipped.
//! Of constraints between nodes the mesh remembers that they were.
//! Elements of a type that is not supported are left out, and sets that hold one remember it, as surfaces remember a face that is not.
//! The format is described in the Abaqus manuals, "Input syntax rules" and the
//! keyword reference.

mod assembly;
mod lines;
mod sets;
mod surfaces;

use std::collections::{BTreeMap, HashMap, HashSet};

use crate::builder::Builder;
use crate::element::{ElementKind, MOST_NODES};
use crate::error::{Fault, Problem, newlines};
use crate::mesh::{Lost, Mesh, Unread, UnreadConstraint, UnreadElement};
use assembly::{Bystanders, Choice, Placement};
use lines::{Data, Keyword, Lines};
use sets::{Content, Found, Level, Member, Sets, Unusable};
use surfaces::Surfaces;

/// Reads a mesh from the content of an input file. `instance`: which one, if there are several.
pub(crate) fn read(bytes: &[u8], instance: Option<&str>) -> Result<Mesh, Fault> {
    let mut deck = Deck {
        lines: Lines::new(bytes),
        builder: Builder::default(),
        node_sets: Sets::new("node"),
        element_sets: Sets::new("element"),
        surfaces: Surfaces::default(),
        scope: Scope::Model,
        is_read: true,
        choice: Choice::of(bytes, instance)?,
        placement: Placement::default(),
        bystanders: Bystanders::default(),
        unread: Vec::new(),
        stiff: Vec::new(),
        sections: Vec::new(),
        unread_index: HashMap::new(),
        constraints: Vec::new(),
    };
    while let Some(keyword) = deck.lines.keyword()? {
        deck.read_block(keyword)?;
    }
    deck.into_mesh(bytes)
}

/// The block of the file being read.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Scope {
    Model,
    Part,
    Assembly,
    Instance,
}

struct Deck<'a> {
    lines: Lines<'a>,
    builder: Builder,
    node_sets: Sets,
    element_sets: Sets,
    surfaces: Surfaces,
    scope: Scope,
    /// Whether the block is of the chosen instance or around it.
    is_read: bool,
    choice: Choice,
    placement: Placement,
    bystanders: Bystanders,
    /// Elements of types that are not supported: numbers, types and where they are.
    unread: Vec<(u64, String, usize)>,
    /// Numbers of trusses, beams, shells, membranes and elements in a plane, with their types.
    stiff: Vec<(u64, String)>,
    /// Element sets that sections name: in Abaqus an element without one carries nothing.
    sections: Vec<(Level, String)>,
    /// Their places, by tag.
    unread_index: HashMap<u64, usize>,
    /// Keywords of constraints, where they are, and the sets that they name.
    constraints: Vec<(&'static str, usize, Option<String>)>,
}

/// Keywords that tie nodes to one another, without their blanks and with them.
const CONSTRAINTS: [(&str, &str); 11] = [
    ("TIE", "TIE"),
    ("EQUATION", "EQUATION"),
    ("MPC", "MPC"),
    ("RIGIDBODY", "RIGID BODY"),
    ("COUPLING", "COUPLING"),
    ("KINEMATICCOUPLING", "KINEMATIC COUPLING"),
    ("DISTRIBUTINGCOUPLING", "DISTRIBUTING COUPLING"),
    ("EMBEDDEDELEMENT", "EMBEDDED ELEMENT"),
    ("SHELLTOSOLIDCOUPLING", "SHELL TO SOLID COUPLING"),
    ("CYCLICSYMMETRYMODEL", "CYCLIC SYMMETRY MODEL"),
    ("PRE-TENSIONSECTION", "PRE-TENSION SECTION"),
];

impl Deck<'_> {
    /// Reads a keyword's data lines, if they are of the mesh.
    fn read_block(&mut self, keyword: Keyword) -> Result<(), Fault> {
        keyword.refuse_slip()?;
        // Parameters of other parts are nobody's concern.
        let keyword = &if self.is_read { keyword.spelled_out()? } else { keyword };
        match keyword.name.as_str() {
            "PART" => self.enter(Scope::Part, self.choice.is_part(keyword.required("NAME")?)),
            "INSTANCE" => self.begin_instance(keyword),
            "ASSEMBLY" | "ENDINSTANCE" => self.enter(Scope::Assembly, true),
            "ENDPART" | "ENDASSEMBLY" => self.enter(Scope::Model, true),
            _ if !self.is_read => {
                self.lines.skip_data();
                Ok(())
            }
            "NODE" => self.read_nodes(keyword),
            "ELEMENT" => self.read_elements(keyword),
            "NSET" => self.read_set(keyword, SetKind::Node),
            "ELSET" => self.read_set(keyword, SetKind::Element),
            "SURFACE" => self.read_surface(keyword),
            "INCLUDE" => Err(refused(keyword, "insert the included file at this place")),
            "NGEN" | "NFILL" | "NCOPY" | "NMAP" | "ELGEN" | "ELCOPY" => {
                Err(refused(keyword, "write all nodes and elements out"))
            }
            "SYSTEM" => Err(refused(keyword, "write the nodes in global coordinates")),
            "IMPERFECTION" | "ADJUST" => Err(refused(keyword, "write the nodes where they are moved to")),
            "IMPORT" | "SYMMETRICMODELGENERATION" => {
                Err(refused(keyword, "write the nodes and elements of that model out"))
            }
            unspaced => {
                if let Some(&(_, name)) = CONSTRAINTS.iter().find(|(known, _)| *known == unspaced) {
                    let elements = keyword.value("ELSET").map(str::to_owned);
                    self.constraints.push((name, keyword.at, elements));
                } else if unspaced.ends_with("SECTION") {
                    self.sections.extend(keyword.value("ELSET").map(|name| (self.level(), name.to_owned())));
                }
                self.lines.skip_data();
                Ok(())
            }
        }
    }

    fn enter(&mut self, scope: Scope, is_read: bool) -> Result<(), Fault> {
        (self.scope, self.is_read) = (scope, is_read);
        Ok(())
    }

    fn begin_instance(&mut self, keyword: &Keyword) -> Result<(), Fault> {
        let is_read = self.choice.is_instance(keyword.required("NAME")?);
        let placement = Placement::read(&mut self.lines)?;
        if is_read {
            self.placement = placement;
        }
        self.enter(Scope::Instance, is_read)
    }

    fn level(&self) -> Level {
        match self.scope {
            Scope::Part | Scope::Instance => Level::Part,
            Scope::Model | Scope::Assembly => Level::Model,
        }
    }

    /// Refuses what would add to the mesh from another file.
    fn refuse_input(&self, keyword: &Keyword) -> Result<(), Fault> {
        if keyword.has("INPUT") {
            return Err(refused(keyword, "INPUT= cannot be followed; insert the file at this place"));
        }
        Ok(())
    }

    /// Nodes or elements of the assembly itself. The set that they may name has nothing of the instance in it.
    fn pass_by(&mut self, keyword: &Keyword, kind: SetKind) -> Result<(), Fault> {
        let level = self.level();
        if let Some(name) = keyword.value(kind.parameter()) {
            self.sets_mut(kind).names.define(level, name);
        }
        // None of the elements that an assembly may have has more nodes than a line holds.
        while let Some(Data { at, fields, .. }) = self.lines.data() {
            self.bystanders.insert(kind, parse_tag(&fields[0], at, "a number of a node or an element")?);
        }
        Ok(())
    }

    /// Nodes, one a line. Coordinates that are left out are 0.
    fn read_nodes(&mut self, keyword: &Keyword) -> Result<(), Fault> {
        self.refuse_input(keyword)?;
        if self.scope == Scope::Assembly {
            return self.pass_by(keyword, SetKind::Node);
        }
        if keyword.value("SYSTEM").is_some_and(|system| !system.eq_ignore_ascii_case("R")) {
            return Err(refused(keyword, "write the nodes in rectangular coordinates"));
        }
        let set = keyword.value("NSET").map(|name| self.node_sets.names.define(self.level(), name));
        while let Some(Data { at, fields, .. }) = self.lines.data() {
            // Three direction cosines may follow the coordinates.
            if fields.len() > 7 && fields[7..].iter().any(|field| !field.is_empty()) {
                return Err(Fault::unexpected(at, "a node: number, x, y, z", fields.join(", ")));
            }
            let tag = parse_tag(&fields[0], at, "a node number")?;
            let mut coordinates = [0.0; 3];
            for (coordinate, field) in coordinates.iter_mut().zip(&fields[1..]) {
                if !field.is_empty() {
                    *coordinate = parse_real(field, at, "a coordinate")?;
                }
            }
            self.builder.add_node((tag, at), (coordinates, at))?;
            if let Some(set) = set {
                self.node_sets.add(set, Member::tag(tag), at);
            }
        }
        Ok(())
    }

    fn read_elements(&mut self, keyword: &Keyword) -> Result<(), Fault> {
        self.refuse_input(keyword)?;
        if self.scope == Scope::Assembly {
            return self.pass_by(keyword, SetKind::Element);
        }
        let name = keyword.required("TYPE")?.to_uppercase();
        let set = keyword.value("ELSET").map(|name| self.element_sets.names.define(self.level(), name));
        let kind = element_kind(&name);
        let form = match kind {
            Some(kind) => format!("an element {name}: number and {} nodes", kind.node_count()),
            None => String::new(),
        };
        loop {
            // A node may follow that a beam's section is oriented by.
            let more = usize::from(name.starts_with('B'));
            let record = match kind {
                Some(kind) => self.lines.record(1 + kind.node_count(), more, &form)?,
                None if is_small(&name) => self.lines.data(),
                None => self.lines.open_record(),
            };
            let Some(record) = record else { return Ok(()) };
            let (at, fields) = (record.at, &record.fields);
            let tag = parse_tag(&fields[0], at, "an element number")?;
            let is_known = self.unread_index.contains_key(&tag);
            if is_known || (kind.is_none() && self.builder.element_index(tag).is_some()) {
                return Err(Fault::new(at, Problem::DuplicateElement { tag }));
            }
            if let Some(kind) = kind {
                let mut nodes = [0; MOST_NODES];
                for (k, field) in fields.iter().enumerate().skip(1) {
                    nodes[k - 1] = parse_tag(self.local(field), record.place(k), "a node number")?;
                }
                // Abaqus has the middle of a line between its ends.
                if kind == ElementKind::Line3 {
                    nodes.swap(1, 2);
                }
                self.builder.add_element(kind, tag, nodes, at)?;
                self.builder.set_incompatible_modes(matches!(name.as_str(), "C3D8I" | "C3D8IH"));
                if has_stiffness_elsewhere(&name) {
                    self.stiff.push((tag, name.clone()));
                }
            } else {
                self.unread_index.insert(tag, self.unread.len());
                self.unread.push((tag, name.clone(), at));
            }
            if let Some(set) = set {
                self.element_sets.add(set, Member::tag(tag), at);
            }
        }
    }

    fn read_set(&mut self, keyword: &Keyword, kind: SetKind) -> Result<(), Fault> {
        let parameter = kind.parameter();
        let name = keyword.required(parameter)?;
        if kind == SetKind::Node && keyword.has("ELSET") {
            return Err(refused(keyword, "ELSET= cannot be followed; list the nodes"));
        }
        let level = self.level();
        let set = self.sets_mut(kind).names.define(level, name);
        let of_instance = match keyword.value("INSTANCE") {
            None => false,
            Some(instance) if self.choice.is_instance(instance) => true,
            Some(instance) if self.choice.is_other(instance) => {
                self.lines.skip_data();
                return Ok(());
            }
            Some(other) => {
                return Err(Fault::unexpected(keyword.at, "INSTANCE= with the name of an instance", other));
            }
        };
        while let Some(Data { at, fields, .. }) = self.lines.data() {
            if keyword.has("GENERATE") {
                let member = parse_range(&fields, at)?;
                if !matches!(member, Member::Tags { first, .. } if self.is_bystander(kind, of_instance, first))
                {
                    self.sets_mut(kind).add(set, member, at);
                }
                continue;
            }
            for field in fields.iter().filter(|field| !field.is_empty()) {
                match self.member(field, kind, of_instance, name, at) {
                    Ok(None) => {}
                    Ok(Some(member)) => self.sets_mut(kind).add(set, member, at),
                    // meshio writes what bounds Gmsh's entities like this: a fault only where the set is asked for.
                    Err(Fault { problem: Problem::WrongLabel { label, .. }, .. })
                        if kind == SetKind::Element =>
                    {
                        self.element_sets.add_wrong(set, label, at);
                    }
                    Err(fault) => return Err(fault),
                }
            }
        }
        Ok(())
    }

    fn read_surface(&mut self, keyword: &Keyword) -> Result<(), Fault> {
        let name = keyword.required("NAME")?;
        let kind = match keyword.value("TYPE").map(str::to_uppercase).as_deref() {
            None | Some("ELEMENT") => SetKind::Element,
            Some("NODE") => SetKind::Node,
            Some(other) => {
                return Err(Fault::unexpected(keyword.at, "*SURFACE of TYPE=ELEMENT or TYPE=NODE", other));
            }
        };
        if keyword.has("COMBINE") || keyword.has("CROP") {
            return Err(refused(
                keyword,
                "COMBINE= and CROP cannot be followed; list the surface's elements",
            ));
        }
        let level = self.level();
        let surface = self.surfaces.define(kind, level, name);
        while let Some(Data { at, fields, .. }) = self.lines.data() {
            let Some(member) = self.member(&fields[0], kind, false, name, at)? else { continue };
            match kind {
                SetKind::Node => self.surfaces.add_nodes(surface, member, at),
                SetKind::Element => {
                    let face = fields.get(1).map_or("", String::as_str);
                    self.surfaces.add_face(surface, member, face, at)?;
                }
            }
        }
        Ok(())
    }

    fn sets_mut(&mut self, kind: SetKind) -> &mut Sets {
        match kind {
            SetKind::Node => &mut self.node_sets,
            SetKind::Element => &mut self.element_sets,
        }
    }

    /// Whether a tag without an instance's name is of the assembly itself.
    fn is_bystander(&self, kind: SetKind, of_instance: bool, tag: u64) -> bool {
        self.scope == Scope::Assembly && !of_instance && self.bystanders.of(kind).contains(&tag)
    }

    /// A label without the instance's name before it: `Part-1-1.Top` is `Top`.
    fn local<'f>(&self, label: &'f str) -> &'f str {
        match label.split_once('.') {
            Some((instance, rest)) if self.choice.is_instance(instance) => rest,
            _ => label,
        }
    }

    /// What a field of a set or surface refers to: a tag, or a set defined above; `None` if it is nothing of the chosen instance.
    fn member(
        &self,
        field: &str,
        kind: SetKind,
        of_instance: bool,
        referrer: &str,
        at: usize,
    ) -> Result<Option<Member>, Fault> {
        if field.split_once('.').is_some_and(|(instance, _)| self.choice.is_other(instance)) {
            return Ok(None);
        }
        let label = self.local(field);
        let of_instance = of_instance || label.len() < field.len();
        if let Ok(tag) = label.parse() {
            return Ok((!self.is_bystander(kind, of_instance, tag)).then(|| Member::tag(tag)));
        }
        let sets = match kind {
            SetKind::Node => &self.node_sets,
            SetKind::Element => &self.element_sets,
        };
        let levels = match (self.level(), of_instance) {
            (Level::Part, _) | (Level::Model, true) => [Level::Part, Level::Model],
            (Level::Model, false) => [Level::Model, Level::Part],
        };
        let found = levels.into_iter().find_map(|level| sets.names.find(level, label)).map(Member::Set);
        found.map(Some).ok_or_else(|| {
            let set = referrer.to_string();
            // A number, and no tag: negative.
            if label.parse::<i64>().is_ok() {
                let wrong = Problem::WrongLabel { set, label: label.into(), what: sets.of };
                return Fault::new(at, wrong);
            }
            let member = format!("{} set {field:?} (sets must be defined before they are used)", sets.of);
            Fault::new(at, Problem::MissingMember { set, member })
        })
    }

    fn into_mesh(self, bytes: &[u8]) -> Result<Mesh, Fault> {
        let Deck { builder, node_sets, element_sets, surfaces, choice, placement, .. } = self;
        let mut line = line_numbers(bytes);
        let constraint = |(keyword, at, elements)| UnreadConstraint { keyword, line: line(at), elements };
        let constraints = self.constraints.into_iter().map(constraint).collect();
        let mut line = line_numbers(bytes);
        let unread = |(tag, kind, at)| UnreadElement { tag, kind, line: line(at) };
        let unread_elements: Vec<UnreadElement> = self.unread.into_iter().map(unread).collect();
        let elements = builder.resolved_elements()?;
        let last_node = builder.node_tags().iter().copied().max().unwrap_or(0);
        let read_elements = elements.iter().map(|element| element.tag());
        let last_element =
            read_elements.chain(unread_elements.iter().map(|element| element.tag)).max().unwrap_or(0);
        let node = |tag| {
            let missing = Found::Missing { is_beyond: tag > last_node };
            builder.node_index(tag).map_or(missing, Found::Index)
        };
        let element = |tag| match builder.element_index(tag) {
            Some(index) => Found::Index(index),
            None if self.unread_index.contains_key(&tag) => Found::Unread,
            None => Found::Missing { is_beyond: tag > last_element },
        };
        let nodes_in = node_sets.resolve(node)?;
        let elements_in = element_sets.resolve(element)?;
        let node_surfaces = surfaces.resolve_nodes(&node_sets, &nodes_in, node)?;
        let facets = surfaces.resolve_facets(&element_sets, &elements_in, element, &elements)?;

        let owner = choice.owner();
        let mut line = line_numbers(bytes);
        let wrong = element_sets.wrong.iter();
        let wrong_labels: Vec<Lost> =
            wrong.map(|(label, at)| Lost::Label { label: label.clone(), line: line(*at) }).collect();
        let lost = |unusable: &Option<Unusable>| {
            Some(match (*unusable)? {
                Unusable::Element(tag) => Lost::Element(self.unread_index[&tag]),
                Unusable::Label(wrong) => wrong_labels[wrong].clone(),
            })
        };
        let unread = Unread {
            in_sets: named(
                element_sets.names.publish(elements_in.iter().map(|set| lost(&set.unread)).collect(), &owner),
            ),
            in_surfaces: named(
                surfaces.publish(facets.iter().map(|surface| lost(&surface.unread)).collect(), &owner),
            ),
            faces: named(
                surfaces.publish(facets.iter().map(|surface| surface.unsupported.clone()).collect(), &owner),
            ),
            elements: unread_elements,
        };
        let sorted = |sets: Vec<Content>| {
            sets.into_iter().map(|set| set.indices.into_iter().collect::<Vec<usize>>()).collect()
        };
        let mut public_node_sets = node_sets.names.publish(sorted(nodes_in), &owner);
        surfaces.merge_node_surfaces(&mut public_node_sets, node_surfaces, &owner)?;
        let numbers = self.sections.iter().filter_map(|(level, name)| element_sets.names.find(*level, name));
        let with_section: HashSet<usize> =
            numbers.flat_map(|number| elements_in[number].indices.iter().copied()).collect();
        let element_sets = element_sets.names.publish(sorted(elements_in), &owner);
        let stiff =
            self.stiff.into_iter().filter_map(|(tag, kind)| Some((builder.element_index(tag)?, kind)));
        let stiff = stiff.filter(|(index, _)| with_section.contains(index)).collect();
        let surfaces = surfaces.publish(facets.into_iter().map(|surface| surface.facets).collect(), &owner);
        let (mut nodes, node_tags) = builder.into_nodes();
        placement.apply(&mut nodes, &node_tags)?;
        Ok(Mesh {
            nodes,
            node_tags,
            elements,
            node_sets: public_node_sets,
            element_sets,
            surfaces,
            unread,
            stiff,
            constraints,
        })
    }
}

/// Lines of places in the file, which are asked for in ascending order.
fn line_numbers(bytes: &[u8]) -> impl FnMut(usize) -> usize + '_ {
    let (mut line, mut counted) = (1, 0);
    move |at| {
        line += newlines(&bytes[counted..at]);
        counted = at;
        line
    }
}

/// The names that something stands under.
fn named<T>(all: BTreeMap<String, Option<T>>) -> BTreeMap<String, T> {
    all.into_iter().filter_map(|(name, one)| Some((name, one?))).collect()
}

/// Sets of nodes or sets of elements.
#[derive(Clone, Copy, PartialEq, Eq)]
enum SetKind {
    Node,
    Element,
}

impl SetKind {
    fn parameter(self) -> &'static str {
        match self {
            SetKind::Node => "NSET",
            SetKind::Element => "ELSET",
        }
    }
}

fn refused(keyword: &Keyword, advice: &'static str) -> Fault {
    Fault::unsupported(keyword.at, format!("*{} as used here", keyword.name), advice)
}

fn parse_tag(field: &str, at: usize, what: &str) -> Result<u64, Fault> {
    field.parse().map_err(|_| Fault::unexpected(at, what, field))
}

/// A real number, as Fortran writes it too: `1.5D-3`.
fn parse_real(field: &str, at: usize, what: &str) -> Result<f64, Fault> {
    field
        .parse()
        .or_else(|_| field.replace(['d', 'D'], "e").parse())
        .map_err(|_| Fault::unexpected(at, what, field))
}

/// A line below `GENERATE`: first, last and, if it is not 1, the increment.
fn parse_range(fields: &[String], at: usize) -> Result<Member, Fault> {
    const FORM: &str = "first, last and increment (positive integers, first <= last)";
    let wrong = || Fault::unexpected(at, FORM, fields.join(", "));
    let numbers = fields.iter().filter(|field| !field.is_empty()).map(|field| field.parse());
    let numbers: Vec<u64> = numbers.collect::<Result<_, _>>().map_err(|_| wrong())?;
    match numbers[..] {
        [first, last] if first <= last => Ok(Member::Tags { first, last, step: 1 }),
        [first, last, step] if first <= last && step > 0 => Ok(Member::Tags { first, last, step }),
        _ => Err(wrong()),
    }
}

/// Whether an element of this type that is not supported has one node or two: its lines may end with a comma and are not continued.
fn is_small(name: &str) -> bool {
    ["MASS", "ROTARYI", "HEATCAP", "SPRING", "DASHPOT", "CONN", "DCOUP"]
        .iter()
        .any(|begin| name.starts_with(begin))
}

/// Whether elements of this type, which are lines or facets here, carry something in Abaqus if they have a section.
fn has_stiffness_elsewhere(name: &str) -> bool {
    let begins = ["T3D", "B3", "S3", "S4", "S6", "S8", "STRI", "M3D", "CPE", "CPS", "CAX"];
    begins.iter().any(|begin| name.starts_with(begin))
}

/// The kind of an Abaqus element type, given in upper case.
fn element_kind(name: &str) -> Option<ElementKind> {
    Some(match name {
        "C3D8" | "C3D8R" | "C3D8I" | "C3D8H" | "C3D8RH" | "C3D8IH" | "C3D8T" | "C3D8RT" => {
            ElementKind::Hexahedron8
        }
        "C3D20" | "C3D20R" | "C3D20H" | "C3D20RH" | "C3D20T" | "C3D20RT" => ElementKind::Hexahedron20,
        "C3D4" | "C3D4H" | "C3D4T" => ElementKind::Tetrahedron4,
        "C3D10" | "C3D10M" | "C3D10H" | "C3D10MH" | "C3D10HS" | "C3D10I" | "C3D10T" => {
            ElementKind::Tetrahedron10
        }
        "C3D6" | "C3D6H" | "C3D6T" => ElementKind::Wedge6,
        "C3D15" | "C3D15H" | "C3D15T" => ElementKind::Wedge15,
        "S4" | "S4R" | "S4RS" | "S4R5" | "R3D4" | "M3D4" | "M3D4R" | "SFM3D4" | "SFM3D4R" => {
            ElementKind::Quadrilateral4
        }
        "S3" | "S3R" | "S3RS" | "STRI3" | "R3D3" | "M3D3" | "SFM3D3" => ElementKind::Triangle3,
        "S8" | "S8R" | "S8R5" | "M3D8" | "M3D8R" | "SFM3D8" | "SFM3D8R" => ElementKind::Quadrilateral8,
        "S6" | "STRI65" | "M3D6" | "SFM3D6" => ElementKind::Triangle6,
        "T3D2" | "B31" => ElementKind::Line2,
        "T3D3" | "B32" => ElementKind::Line3,
        _ => return planar_kind(name),
    })
}

/// The kind of an element in a plane: what Gmsh (CPS) and meshio (CPE, CAX) call the facets of a surface when they export to Abaqus.
fn planar_kind(name: &str) -> Option<ElementKind> {
    let rest = ["CPS", "CPE", "CAX"].iter().find_map(|begin| name.strip_prefix(begin))?;
    let (nodes, formulation) = rest.split_at_checked(1)?;
    // Hybrid, incompatible, modified, pore pressure, reduced, temperature: the nodes are the same.
    if !formulation.bytes().all(|letter| b"HIMPRT".contains(&letter)) {
        return None;
    }
    Some(match nodes {
        "3" => ElementKind::Triangle3,
        "4" => ElementKind::Quadrilateral4,
        "6" => ElementKind::Triangle6,
        "8" => ElementKind::Quadrilateral8,
        _ => return None,
    })
}
