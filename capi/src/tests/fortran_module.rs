//! The Fortran module declares what the header declares: every function with its arguments in order, by value or by reference, with
//! their kinds; every structure with its members; every enumerator with its number.

use std::collections::BTreeMap;
use std::path::Path;

fn text(path: &str) -> String {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    std::fs::read_to_string(root.join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// How a value goes from Fortran to C, in the words of the Fortran module.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Passed {
    name: String,
    kind: String,
    by_value: bool,
    is_written: bool,
}

/// A function: its arguments and what it returns.
type Functions = BTreeMap<String, (Vec<Passed>, String)>;
/// Members with their kinds and numbers of entries.
type Structures = BTreeMap<String, Vec<(String, String, usize)>>;
type Enumerators = BTreeMap<String, i64>;

/// The kind of a type of C.
fn kind(ctype: &str) -> String {
    let ctype = ctype.replace("const ", "").replace("struct ", "").replace("enum ", "");
    match ctype.trim() {
        "double" => "c_double".into(),
        "int32_t" => "c_int32_t".into(),
        "int64_t" => "c_int64_t".into(),
        "size_t" => "c_size_t".into(),
        "char" => "c_char".into(),
        "dc_status" => "c_int".into(),
        "dc_normal_law" | "dc_friction_law" => "c_funptr".into(),
        // The name of the type would be that of a function.
        "dc_contact" => "dc_contact_data".into(),
        other => other.into(),
    }
}

/// Kind of a pointer's target as an argument, whether it is passed by value, and whether it is written.
fn passed(name: &str, ctype: &str) -> Passed {
    let stars = ctype.matches('*').count();
    let base = kind(&ctype.replace('*', ""));
    const HANDLES: [&str; 7] =
        ["dc_interface", "dc_pattern", "dc_map", "dc_operator", "dc_faces", "dc_window", "dc_part"];
    let is_handle = HANDLES.contains(&base.as_str());
    let (kind, by_value) = match (stars, is_handle) {
        (0, _) => (base, true),
        (1, true) => ("c_ptr".into(), true),
        (1, false) => (base, false),
        (2, true) => ("c_ptr".into(), false),
        _ => panic!("{ctype} {name}"),
    };
    let is_written = !by_value && !ctype.contains("const ");
    Passed { name: name.into(), kind, by_value, is_written }
}

struct Header {
    functions: Functions,
    structures: Structures,
    enumerators: Enumerators,
}

fn header() -> Header {
    let text = text("capi/include/diffuse_contact.h");
    let mut code = String::new();
    let without_blocks = text.split("/*").map(|part| part.split_once("*/").map_or(part, |(_, rest)| rest));
    for line in without_blocks.collect::<String>().lines() {
        let line = line.split("//").next().unwrap_or_default().trim();
        if !line.starts_with('#') && !line.contains("extern \"C\"") {
            code += line;
            code.push(' ');
        }
    }
    let mut header =
        Header { functions: BTreeMap::new(), structures: BTreeMap::new(), enumerators: BTreeMap::new() };
    let mut rest = code.as_str();
    while let Some(end) = rest.find([';', '{']) {
        let (head, open) = (rest[..end].trim().trim_start_matches('}').trim(), rest.as_bytes()[end] == b'{');
        rest = &rest[end + 1..];
        if open {
            let (body, after) = rest.split_once('}').expect("a closing brace");
            rest = after;
            if head.contains("enum") {
                enumerators(body, &mut header.enumerators);
            } else {
                let name = head.rsplit(' ').next().expect("a name").to_owned();
                header.structures.insert(name, members(body));
            }
        } else if head.starts_with("typedef") {
            // Types of functions of the caller's: pointers to Fortran.
        } else if let Some((declared, arguments)) = head.split_once('(') {
            let (result, name) = declared.rsplit_once([' ', '*']).expect("a result");
            let result = if declared.contains('*') { "c_ptr".into() } else { kind(result) };
            let arguments = arguments.trim_end_matches(')').split(',').map(str::trim);
            let arguments = arguments.filter(|argument| *argument != "void").map(|argument| {
                let start = argument.rfind([' ', '*']).expect("a type") + 1;
                passed(&argument[start..], &argument[..start])
            });
            header.functions.insert(name.to_owned(), (arguments.collect(), result));
        }
    }
    header
}

fn enumerators(body: &str, into: &mut Enumerators) {
    for entry in body.split(',').map(str::trim).filter(|entry| !entry.is_empty()) {
        let (name, number) = entry.split_once('=').expect("a number");
        into.insert(name.trim().to_owned(), number.trim().parse().expect("a number"));
    }
}

fn members(body: &str) -> Vec<(String, String, usize)> {
    let member = |member: &str| {
        let start = member.rfind([' ', '*']).expect("a type") + 1;
        let (name, count) = member[start..].split_once('[').unwrap_or((&member[start..], "1]"));
        let count = count.trim_end_matches(']').parse().expect("a length");
        let ctype = &member[..start];
        let kind = if ctype.contains('*') { "c_ptr".to_owned() } else { kind(ctype) };
        (name.to_owned(), kind, count)
    };
    body.split(';').map(str::trim).filter(|text| !text.is_empty()).map(member).collect()
}

/// The statements of the module, continued lines joined, comments left out.
fn statements() -> Vec<String> {
    let mut statements = vec![String::new()];
    for line in text("fortran/diffuse_contact.f90").lines() {
        let line = line.split('!').next().unwrap_or_default().trim();
        let last = statements.last_mut().expect("one");
        match line.strip_suffix('&') {
            Some(line) => *last += line,
            None => {
                *last += line;
                statements.push(String::new());
            }
        }
    }
    statements.retain(|statement| !statement.is_empty());
    statements
}

/// Splits at commas outside parentheses.
fn split(list: &str) -> Vec<String> {
    let (mut parts, mut depth) = (vec![String::new()], 0);
    for letter in list.chars() {
        depth += i32::from(letter == '(') - i32::from(letter == ')');
        if letter == ',' && depth == 0 {
            parts.push(String::new());
        } else {
            parts.last_mut().expect("one").push(letter);
        }
    }
    parts.into_iter().map(|part| part.trim().to_owned()).collect()
}

/// The inside of the first pair of parentheses that belong together.
fn inside(text: &str) -> &str {
    let start = text.find('(').expect("(") + 1;
    let mut depth = 1;
    for (k, letter) in text[start..].char_indices() {
        depth += i32::from(letter == '(') - i32::from(letter == ')');
        if depth == 0 {
            return &text[start..start + k];
        }
    }
    panic!("{text}")
}

/// Names, kind, attributes and lengths of a declaration.
fn declared(statement: &str) -> (String, Vec<String>, Vec<(String, usize)>) {
    let (left, right) = statement.split_once("::").unwrap_or_else(|| panic!("{statement}"));
    let mut attributes = split(left);
    let kind = inside(&attributes.remove(0)).replace("kind=", "");
    let name = |entry: &String| {
        let entry = entry.split('=').next().expect("a name").trim();
        match entry.split_once('(') {
            Some((name, length)) => (name.to_owned(), length.trim_end_matches(')').parse().unwrap_or(0)),
            None => (entry.to_owned(), 1),
        }
    };
    (kind, attributes, split(right).iter().map(name).collect())
}

struct Module {
    functions: Functions,
    /// Arguments that are optional.
    optional: Vec<(String, String)>,
    structures: Structures,
    enumerators: Enumerators,
}

fn module() -> Module {
    let statements = statements();
    let mut module = Module {
        functions: BTreeMap::new(),
        optional: Vec::new(),
        structures: BTreeMap::new(),
        enumerators: BTreeMap::new(),
    };
    let mut k = 0;
    while k < statements.len() {
        let statement = &statements[k];
        k += 1;
        let body = |end: &str| {
            let length = statements[k..].iter().position(|line| line.starts_with(end));
            &statements[k..k + length.unwrap_or_else(|| panic!("{end} of {statement}"))]
        };
        if let Some(list) = statement.strip_prefix("enumerator ::") {
            let mut next = 0;
            for entry in split(list) {
                let (name, number) = entry.split_once('=').unwrap_or((&entry, ""));
                next = number.trim().parse().unwrap_or(next);
                module.enumerators.insert(name.trim().to_owned(), next);
                next += 1;
            }
        } else if let Some(name) = statement.strip_prefix("type, bind(c) ::") {
            let mut members = Vec::new();
            for line in body("end type") {
                let (kind, _, names) = declared(line);
                members.extend(names.into_iter().map(|(name, count)| (name, kind.clone(), count)));
            }
            module.structures.insert(name.trim().to_owned(), members);
        } else if statement.starts_with("function dc_") && statement.contains("bind(c)") {
            let name = statement["function ".len()..].split('(').next().expect("a name").to_owned();
            let order = split(inside(statement));
            let result = inside(&statement[statement.find("result").expect("result")..]).to_owned();
            let mut known = BTreeMap::new();
            for line in body("end function").iter().filter(|line| !line.starts_with("import")) {
                let (kind, attributes, names) = declared(line);
                for (argument, _) in names {
                    let has = |word: &str| attributes.iter().any(|attribute| attribute == word);
                    if has("optional") {
                        module.optional.push((name.clone(), argument.clone()));
                    }
                    let is_written = has("intent(out)") || has("intent(inout)");
                    let (kind, by_value) = (kind.clone(), has("value"));
                    known.insert(argument.clone(), Passed { name: argument, kind, by_value, is_written });
                }
            }
            let returned = known.remove(&result).unwrap_or_else(|| panic!("{name}: {result}")).kind;
            let arguments = order.iter().filter(|argument| !argument.is_empty());
            let arguments = arguments.map(|argument| {
                known.remove(argument).unwrap_or_else(|| panic!("{name}: {argument} is not declared"))
            });
            let arguments = arguments.collect();
            assert!(known.is_empty(), "{name}: {known:?}");
            module.functions.insert(name, (arguments, returned));
        }
    }
    module
}

#[test]
fn functions_are_those_of_the_header() {
    let (header, module) = (header().functions, module().functions);
    assert!(header.len() >= 30, "{} functions", header.len());
    assert_eq!(header.keys().collect::<Vec<_>>(), module.keys().collect::<Vec<_>>());
    for (name, expected) in &header {
        assert_eq!(&module[name], expected, "{name}");
    }
}

#[test]
fn structures_are_those_of_the_header() {
    let (header, module) = (header().structures, module().structures);
    assert!(header.len() >= 7, "{header:?}");
    for (name, expected) in &header {
        assert_eq!(module.get(&kind(name)), Some(expected), "{name}");
    }
    assert_eq!(header.len(), module.len());
}

#[test]
fn sizes_are_those_of_the_members() {
    let text = text("fortran/diffuse_contact.f90");
    for (name, members) in module().structures {
        if members[0].0 != "size" {
            continue;
        }
        let bytes: usize =
            members.iter().map(|(_, kind, count)| count * if kind == "c_int32_t" { 4 } else { 8 }).sum();
        let start = text.find(&format!("type, bind(c) :: {name}\n")).expect("the type");
        let rest = &text[start + text[start..].find(":: size = ").expect("a size") + 10..];
        let found: usize = rest.lines().next().expect("a line").trim().parse().expect("a number");
        assert_eq!(found, bytes.next_multiple_of(8), "{name}");
    }
}

#[test]
fn enumerators_are_those_of_the_header() {
    assert_eq!(header().enumerators, module().enumerators);
}

/// What the header says may be NULL, and handles that may not.
#[test]
fn what_may_be_null_is_optional() {
    let optional = module().optional;
    let is_optional = |function: &str, argument: &str| optional.contains(&(function.into(), argument.into()));
    for (function, argument) in [
        ("dc_create", "slave_facets"),
        ("dc_create", "options"),
        ("dc_counts", "node_count"),
        ("dc_counts", "slave_count"),
        ("dc_set_symmetry", "planes"),
        ("dc_follow", "rebuilt"),
        ("dc_refresh", "report"),
        ("dc_set_equations", "equations"),
        ("dc_derivatives", "hessian"),
        ("dc_feet", "outcomes"),
        ("dc_feet", "weights"),
        ("dc_feet", "normal"),
        ("dc_gaps", "outcomes"),
        ("dc_forces", "pressures"),
        ("dc_add_forces", "active_count"),
        ("dc_triplets", "values"),
        ("dc_pattern_create", "entry_count"),
        ("dc_pattern_fill", "active_count"),
        ("dc_pattern_structure", "columns"),
        ("dc_pair", "options"),
        ("dc_gap", "hessian"),
        ("dc_gap_batch", "outwards"),
        ("dc_gap_batch", "support_radii"),
        ("dc_element_system", "tangent"),
    ] {
        assert!(is_optional(function, argument), "{function}, {argument}");
    }
    assert!(!is_optional("dc_create", "interface") && !is_optional("dc_update", "positions"));
}
