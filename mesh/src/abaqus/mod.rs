//! Reads the mesh of an Abaqus input file: nodes, elements, sets and surfaces.
//!
//! The file is flat, or has one part with one instance that is not moved. Keywords that create or move nodes
//! and are not supported are refused; all others (materials, steps, ...) are skipped. The format is described
//! in the Abaqus manuals, "Input syntax rules" and the keyword reference.

mod lines;
mod sets;
mod surfaces;

use crate::builder::Builder;
use crate::element::ElementKind;
use crate::error::{Fault, Problem};
use crate::mesh::Mesh;
use lines::{Data, Keyword, Lines};
use sets::{Level, Member, Sets};
use surfaces::Surfaces;

/// Reads a mesh from the content of an input file.
pub(crate) fn read(bytes: &[u8]) -> Result<Mesh, Fault> {
    let mut deck = Deck {
        lines: Lines::new(bytes),
        builder: Builder::default(),
        node_sets: Sets::new("node"),
        element_sets: Sets::new("element"),
        surfaces: Surfaces::default(),
        scope: Scope::Model,
        part: None,
        instance: None,
    };
    while let Some(keyword) = deck.lines.keyword()? {
        deck.read_block(&keyword)?;
    }
    deck.into_mesh()
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
    part: Option<String>,
    instance: Option<String>,
}

impl Deck<'_> {
    /// Reads a keyword's data lines, if they are of the mesh.
    fn read_block(&mut self, keyword: &Keyword) -> Result<(), Fault> {
        match keyword.name.as_str() {
            "NODE" => self.read_nodes(keyword),
            "ELEMENT" => self.read_elements(keyword),
            "NSET" => self.read_set(keyword, SetKind::Node),
            "ELSET" => self.read_set(keyword, SetKind::Element),
            "SURFACE" => self.read_surface(keyword),
            "PART" => self.begin_part(keyword),
            "INSTANCE" => self.begin_instance(keyword),
            "ASSEMBLY" => self.enter(Scope::Assembly),
            "END INSTANCE" => self.enter(Scope::Assembly),
            "END PART" | "END ASSEMBLY" => self.enter(Scope::Model),
            "INCLUDE" => Err(refused(keyword, "insert the included file at this place")),
            "NGEN" | "NFILL" | "NCOPY" | "NMAP" | "ELGEN" | "ELCOPY" => {
                Err(refused(keyword, "write all nodes and elements out"))
            }
            "SYSTEM" => Err(refused(keyword, "write the nodes in global coordinates")),
            _ => {
                while self.lines.data().is_some() {}
                Ok(())
            }
        }
    }

    fn enter(&mut self, scope: Scope) -> Result<(), Fault> {
        self.scope = scope;
        Ok(())
    }

    fn begin_part(&mut self, keyword: &Keyword) -> Result<(), Fault> {
        if self.part.is_some() {
            return Err(refused(keyword, "a second part cannot be read; merge the parts into one"));
        }
        self.part = Some(keyword.required("NAME")?.to_string());
        self.enter(Scope::Part)
    }

    fn begin_instance(&mut self, keyword: &Keyword) -> Result<(), Fault> {
        if self.instance.is_some() {
            return Err(refused(keyword, "a second instance cannot be read; merge the instances into one"));
        }
        self.instance = Some(keyword.required("NAME")?.to_string());
        while let Some(Data { at, fields }) = self.lines.data() {
            for field in fields.iter().filter(|field| !field.is_empty()) {
                if parse_real(field, at, "a translation or rotation of the instance")? != 0.0 {
                    return Err(refused(
                        keyword,
                        "an instance that is translated or rotated cannot be read; write the nodes where they are",
                    ));
                }
            }
        }
        self.enter(Scope::Instance)
    }

    fn level(&self) -> Level {
        match self.scope {
            Scope::Part | Scope::Instance => Level::Part,
            Scope::Model | Scope::Assembly => Level::Model,
        }
    }

    /// Refuses what would add to the mesh from elsewhere: other files, the assembly beside its instance.
    fn refuse_foreign_data(&self, keyword: &Keyword) -> Result<(), Fault> {
        if keyword.has("INPUT") {
            return Err(refused(keyword, "INPUT= cannot be followed; insert the file at this place"));
        }
        if self.scope == Scope::Assembly {
            return Err(refused(keyword, "the assembly may not define a mesh beside its instance"));
        }
        Ok(())
    }

    fn read_nodes(&mut self, keyword: &Keyword) -> Result<(), Fault> {
        self.refuse_foreign_data(keyword)?;
        if keyword.value("SYSTEM").is_some_and(|system| !system.eq_ignore_ascii_case("R")) {
            return Err(refused(keyword, "write the nodes in rectangular coordinates"));
        }
        let set = keyword.value("NSET").map(|name| self.node_sets.names.define(self.level(), name));
        const FORM: &str = "a node: number, x, y, z";
        // Three direction cosines may follow the coordinates.
        while let Some(Data { at, fields }) = self.lines.record(4, 3, FORM)? {
            let tag = parse_tag(&fields[0], at, "a node number")?;
            let mut coordinates = [0.0; 3];
            for (coordinate, field) in coordinates.iter_mut().zip(&fields[1..]) {
                *coordinate = parse_real(field, at, "a coordinate")?;
            }
            self.builder.add_node((tag, at), (coordinates, at))?;
            if let Some(set) = set {
                self.node_sets.add(set, Member::tag(tag), at);
            }
        }
        Ok(())
    }

    fn read_elements(&mut self, keyword: &Keyword) -> Result<(), Fault> {
        self.refuse_foreign_data(keyword)?;
        let name = keyword.required("TYPE")?.to_uppercase();
        let kind = element_kind(&name)
            .ok_or_else(|| Fault::new(keyword.at, Problem::UnsupportedElement { name: name.clone() }))?;
        let set = keyword.value("ELSET").map(|name| self.element_sets.names.define(self.level(), name));
        let form = format!("an element {name}: number and {} nodes", kind.node_count());
        while let Some(Data { at, fields }) = self.lines.record(1 + kind.node_count(), 0, &form)? {
            let tag = parse_tag(&fields[0], at, "an element number")?;
            let mut nodes = [0; 8];
            for (node, field) in nodes.iter_mut().zip(&fields[1..]) {
                *node = parse_tag(self.local(field), at, "a node number")?;
            }
            self.builder.add_element(kind, tag, nodes, at)?;
            if let Some(set) = set {
                self.element_sets.add(set, Member::tag(tag), at);
            }
        }
        Ok(())
    }

    fn read_set(&mut self, keyword: &Keyword, kind: SetKind) -> Result<(), Fault> {
        let parameter = kind.parameter();
        let name = keyword.required(parameter)?;
        if kind == SetKind::Node && keyword.has("ELSET") {
            return Err(refused(keyword, "ELSET= cannot be followed; list the nodes"));
        }
        if let Some(other) = keyword.value("INSTANCE").filter(|name| !self.is_instance(name)) {
            return Err(Fault::unexpected(keyword.at, "INSTANCE= with the name of an instance above", other));
        }
        let level = self.level();
        let set = self.sets_mut(kind).names.define(level, name);
        while let Some(Data { at, fields }) = self.lines.data() {
            if keyword.has("GENERATE") {
                let member = parse_range(&fields, at)?;
                self.sets_mut(kind).add(set, member, at);
                continue;
            }
            for field in fields.iter().filter(|field| !field.is_empty()) {
                let member = self.member(field, kind, keyword.has("INSTANCE"), name, at)?;
                self.sets_mut(kind).add(set, member, at);
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
        while let Some(Data { at, fields }) = self.lines.data() {
            let member = self.member(&fields[0], kind, false, name, at)?;
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

    fn is_instance(&self, name: &str) -> bool {
        self.instance.as_deref().is_some_and(|instance| instance.eq_ignore_ascii_case(name))
    }

    /// A label without the instance's name before it: `Part-1-1.Top` is `Top`.
    fn local<'f>(&self, label: &'f str) -> &'f str {
        match label.split_once('.') {
            Some((instance, rest)) if self.is_instance(instance) => rest,
            _ => label,
        }
    }

    /// What a field of a set or surface refers to: a tag, or a set defined above.
    fn member(
        &self,
        field: &str,
        kind: SetKind,
        of_instance: bool,
        referrer: &str,
        at: usize,
    ) -> Result<Member, Fault> {
        let label = self.local(field);
        if let Ok(tag) = label.parse() {
            return Ok(Member::tag(tag));
        }
        let sets = match kind {
            SetKind::Node => &self.node_sets,
            SetKind::Element => &self.element_sets,
        };
        let of_part = of_instance || label.len() < field.len();
        let levels = match (self.level(), of_part) {
            (Level::Part, _) | (Level::Model, true) => [Level::Part, Level::Model],
            (Level::Model, false) => [Level::Model, Level::Part],
        };
        levels.into_iter().find_map(|level| sets.names.find(level, label)).map(Member::Set).ok_or_else(|| {
            let member = format!("{} set {field:?} (sets must be defined before they are used)", sets.of);
            Fault::new(at, Problem::MissingMember { set: referrer.into(), member })
        })
    }

    fn into_mesh(self) -> Result<Mesh, Fault> {
        let Deck { builder, node_sets, element_sets, surfaces, part, instance, .. } = self;
        let elements = builder.resolved_elements()?;
        let node_index = |tag| builder.node_index(tag);
        let element_index = |tag| builder.element_index(tag);
        let nodes_in = node_sets.resolve(node_index)?;
        let elements_in = element_sets.resolve(element_index)?;
        let node_surfaces = surfaces.resolve_nodes(&node_sets, &nodes_in, node_index)?;
        let facets = surfaces.resolve_facets(&element_sets, &elements_in, element_index, &elements)?;

        let owner = instance.or(part).unwrap_or_default();
        let sorted = |sets: Vec<std::collections::BTreeSet<usize>>| {
            sets.into_iter().map(|set| set.into_iter().collect()).collect()
        };
        let mut public_node_sets = node_sets.names.publish(sorted(nodes_in), &owner);
        surfaces.merge_node_surfaces(&mut public_node_sets, node_surfaces, &owner)?;
        let element_sets = element_sets.names.publish(sorted(elements_in), &owner);
        let surfaces = surfaces.publish_facets(facets, &owner);
        let (nodes, node_tags) = builder.into_nodes();
        Ok(Mesh { nodes, node_tags, elements, node_sets: public_node_sets, element_sets, surfaces })
    }
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
    let feature = format!("*{} as used here", keyword.name);
    Fault::new(keyword.at, Problem::UnsupportedFeature { feature, advice })
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

/// The kind of an Abaqus element type, given in upper case.
fn element_kind(name: &str) -> Option<ElementKind> {
    Some(match name {
        "C3D8" | "C3D8R" | "C3D8I" | "C3D8H" | "C3D8RH" | "C3D8IH" | "C3D8T" | "C3D8RT" => {
            ElementKind::Hexahedron8
        }
        "C3D4" | "C3D4H" | "C3D4T" => ElementKind::Tetrahedron4,
        "S4" | "S4R" | "S4RS" | "S4R5" | "R3D4" | "M3D4" | "M3D4R" | "SFM3D4" | "SFM3D4R" => {
            ElementKind::Quadrilateral4
        }
        "S3" | "S3R" | "S3RS" | "STRI3" | "R3D3" | "M3D3" | "SFM3D3" => ElementKind::Triangle3,
        // What Gmsh calls the facets of a surface when it exports to Abaqus.
        "CPS4" => ElementKind::Quadrilateral4,
        "CPS3" => ElementKind::Triangle3,
        "T3D2" | "B31" => ElementKind::Line2,
        _ => return None,
    })
}
