//! What the documents name in the sources exists: `Type::method`, `module::item` and paths of files. Their links lead somewhere, and the
//! book has all its pages.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use syn::{ImplItem, Item, TraitItem, Type, UseTree};

/// Owners that are not ours.
const FOREIGN: [&str; 3] = ["std", "syn", "array"];
/// What CMake calls the libraries.
const TARGETS: [&str; 2] = ["diffuse_contact::diffuse_contact", "diffuse_contact::static"];
/// Endings of files that stand in the repository if a document names them with a folder.
const ENDINGS: [&str; 9] = [".rs", ".toml", ".py", ".c", ".h", ".f90", ".sh", ".msh", ".md"];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// All files below a folder that end so; build output and hidden folders apart.
fn files(folder: &Path, ending: &str, found: &mut Vec<PathBuf>) {
    // A folder that other tests, which run beside, made and removed is none.
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (path, name) = (entry.path(), entry.file_name().into_string().unwrap_or_default());
        if path.is_dir() && !name.starts_with('.') && name != "target" && !name.ends_with(".results") {
            files(&path, ending, found);
        } else if name.ends_with(ending) {
            found.push(path);
        }
    }
}

/// Owners with what they own: types with methods, fields and variants, modules with items.
#[derive(Default)]
struct Names(HashSet<(String, String)>);

impl Names {
    fn own(&mut self, owner: &str, name: &impl ToString) {
        self.0.insert((owner.to_owned(), name.to_string()));
    }

    fn items(&mut self, module: &str, items: &[Item]) {
        for item in items {
            match item {
                Item::Fn(item) => self.own(module, &item.sig.ident),
                Item::Const(item) => self.own(module, &item.ident),
                Item::Static(item) => self.own(module, &item.ident),
                Item::Type(item) => self.own(module, &item.ident),
                Item::Struct(item) => {
                    self.own(module, &item.ident);
                    let fields = item.fields.iter().filter_map(|field| field.ident.as_ref());
                    fields.for_each(|field| self.own(&item.ident.to_string(), field));
                }
                Item::Enum(item) => {
                    self.own(module, &item.ident);
                    for variant in &item.variants {
                        self.own(&item.ident.to_string(), &variant.ident);
                        let fields = variant.fields.iter().filter_map(|field| field.ident.as_ref());
                        fields.for_each(|field| self.own(&variant.ident.to_string(), field));
                    }
                }
                Item::Trait(item) => {
                    self.own(module, &item.ident);
                    for member in &item.items {
                        match member {
                            TraitItem::Fn(member) => self.own(&item.ident.to_string(), &member.sig.ident),
                            TraitItem::Const(member) => self.own(&item.ident.to_string(), &member.ident),
                            TraitItem::Type(member) => self.own(&item.ident.to_string(), &member.ident),
                            _ => {}
                        }
                    }
                }
                Item::Impl(item) => {
                    let Type::Path(owner) = &*item.self_ty else { continue };
                    let Some(owner) = owner.path.segments.last() else { continue };
                    let owner = owner.ident.to_string();
                    for member in &item.items {
                        match member {
                            ImplItem::Fn(member) => self.own(&owner, &member.sig.ident),
                            ImplItem::Const(member) => self.own(&owner, &member.ident),
                            ImplItem::Type(member) => self.own(&owner, &member.ident),
                            // Functions that are alike, such as those of options: their names stand before their arguments.
                            ImplItem::Macro(member) => {
                                let text = member.mac.tokens.to_string();
                                let before =
                                    text.split('(').filter_map(|piece| piece.split_whitespace().last());
                                before.for_each(|name| self.own(&owner, &name));
                            }
                            _ => {}
                        }
                    }
                }
                Item::Mod(item) => {
                    self.own(module, &item.ident);
                    if let Some((_, items)) = &item.content {
                        self.items(&item.ident.to_string(), items);
                    }
                }
                Item::Use(item) => self.uses(module, &item.tree),
                _ => {}
            }
        }
    }

    /// What a module shows of others.
    fn uses(&mut self, module: &str, tree: &UseTree) {
        match tree {
            UseTree::Path(path) => self.uses(module, &path.tree),
            UseTree::Name(name) => self.own(module, &name.ident),
            UseTree::Rename(name) => self.own(module, &name.rename),
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.uses(module, tree)),
            _ => {}
        }
    }
}

/// The module of a file: its name, or that of its folder, or of its crate's folder.
fn module(path: &Path) -> String {
    let name = |path: &Path| path.file_stem().unwrap().to_str().unwrap().to_owned();
    match name(path).as_str() {
        "mod" => name(path.parent().unwrap()),
        "lib" | "main" => name(path.parent().unwrap().parent().unwrap()),
        other => other.to_owned(),
    }
}

fn names() -> Names {
    let mut sources = Vec::new();
    files(&root(), ".rs", &mut sources);
    let mut names = Names::default();
    for path in sources {
        if let Ok(file) = syn::parse_file(&fs::read_to_string(&path).unwrap()) {
            names.items(&module(&path), &file.items);
        }
    }
    names
}

/// The pieces of a document in single backquotes, blocks of code apart.
fn quoted(text: &str) -> Vec<&str> {
    let prose = text.split("\n```").step_by(2);
    let lines = prose.flat_map(str::lines);
    lines.flat_map(|line| line.split('`').skip(1).step_by(2)).collect()
}

/// `Owner::{a, b}` as pairs; `None` if it is no such path.
fn pairs(piece: &str) -> Option<Vec<(String, String)>> {
    let (path, last) = piece.rsplit_once("::")?;
    let owner = path.rsplit("::").find(|part| !part.contains(['<', '>']))?;
    let is_name =
        |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let members: Vec<&str> = match last.strip_prefix('{') {
        Some(list) => list.strip_suffix('}')?.split(',').map(str::trim).collect(),
        None => vec![last.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).next()?],
    };
    let foreign = path.split("::").any(|part| FOREIGN.contains(&part));
    (is_name(owner) && !foreign && members.iter().all(|member| is_name(member)))
        .then(|| members.into_iter().map(|member| (owner.to_owned(), member.to_owned())).collect())
}

#[test]
fn what_the_documents_name_exists() {
    let names = names();
    let mut documents = Vec::new();
    files(&root(), ".md", &mut documents);
    let mut known = Vec::new();
    files(&root(), "", &mut known);
    let known: HashSet<String> =
        known.iter().map(|path| path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned()).collect();
    let (mut missing, mut checked) = (Vec::new(), 0);
    for document in documents.iter().filter(|path| !path.ends_with("CHANGELOG.md")) {
        let text = fs::read_to_string(document).unwrap();
        let place = document.strip_prefix(root()).unwrap().display();
        for piece in quoted(&text).into_iter().filter(|piece| !TARGETS.contains(piece)) {
            for (owner, member) in pairs(piece).into_iter().flatten() {
                checked += 1;
                if !names.0.contains(&(owner.clone(), member.clone())) {
                    missing.push(format!("{place}: {owner}::{member}"));
                }
            }
            let is_path = piece.contains('/')
                && ENDINGS.iter().any(|ending| piece.ends_with(ending))
                && piece.chars().all(|c| c.is_ascii_alphanumeric() || "/._-".contains(c));
            // A document may leave out the folder that it is about.
            if is_path && !known.iter().any(|file| file == piece || file.ends_with(&format!("/{piece}"))) {
                missing.push(format!("{place}: {piece}"));
            }
        }
    }
    assert!(checked > 50, "{checked}");
    assert!(missing.is_empty(), "not in the sources:\n{}", missing.join("\n"));
}

/// What lines of shells in the documents begin with, but for paths of programs.
const COMMANDS: [&str; 12] = [
    "cargo",
    "cc",
    "cd",
    "diffuse-contact",
    "diffuse-contact-solve",
    "export",
    "gcc",
    "gfortran",
    "mpirun",
    "pip",
    "ruff",
    "sudo",
];

/// The lines of a document's blocks for shells that are no commands, as where two were joined.
fn no_commands(text: &str) -> Vec<&str> {
    let blocks = text.split("\n```").skip(1).step_by(2).filter_map(|block| block.strip_prefix("sh\n"));
    let is_command = |line: &str| {
        let first = line.split_whitespace().next().unwrap_or_default();
        let command = line.split('#').next().unwrap_or_default();
        let is_one = command.split_whitespace().filter(|word| *word == "cargo").count() <= 1;
        (COMMANDS.contains(&first) || first.contains('/') || first.starts_with("python3")) && is_one
    };
    let continues = |before: Option<&str>| before.is_some_and(|before| before.ends_with('\\'));
    let lines = blocks.flat_map(|block| {
        let lines: Vec<&str> = block.lines().collect();
        let before = [None].into_iter().chain(lines.clone().into_iter().map(Some));
        lines.into_iter().zip(before).collect::<Vec<_>>()
    });
    lines
        .filter(|&(line, before)| !line.is_empty() && !continues(before) && !is_command(line))
        .map(|(line, _)| line)
        .collect()
}

#[test]
fn blocks_for_shells_have_a_command_a_line() {
    let mut documents = Vec::new();
    files(&root(), ".md", &mut documents);
    let found: Vec<String> = documents
        .iter()
        .flat_map(|document| {
            let text = fs::read_to_string(document).unwrap();
            let place = document.strip_prefix(root()).unwrap().display();
            no_commands(&text).into_iter().map(|line| format!("{place}: {line}")).collect::<Vec<_>>()
        })
        .collect();
    assert!(found.is_empty(), "no commands:\n{}", found.join("\n"));
    assert_eq!(no_commands("\n```sh\ncargo a # b cargo c\nfor one run\n\ncc a \\\n  b\n```\n").len(), 1);
    assert_eq!(no_commands("\n```sh\ncargo a cargo b\n```\n").len(), 1);
}

/// Cargo's own commands hide aliases of the same name.
#[test]
fn aliases_are_no_commands_of_cargo() {
    let config = fs::read_to_string(root().join(".cargo/config.toml")).unwrap();
    let aliases: Vec<&str> = config
        .lines()
        .skip_while(|line| *line != "[alias]")
        .filter_map(|line| line.split_once(" = "))
        .map(|(name, _)| name)
        .collect();
    assert!(aliases.len() > 2, "{aliases:?}");
    // Where the aliases are not known.
    let cargo = std::env::var("CARGO").unwrap();
    let listed = Command::new(cargo).arg("--list").current_dir(std::env::temp_dir()).output().unwrap();
    let listed = String::from_utf8(listed.stdout).unwrap();
    let own: HashSet<&str> = listed.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert!(own.contains("report"), "{listed}");
    assert!(aliases.iter().all(|alias| !own.contains(alias)), "{aliases:?}");
}

/// Targets of the links of a document, blocks of code apart.
fn links(text: &str) -> Vec<&str> {
    let prose = text.split("\n```").step_by(2);
    prose.flat_map(|piece| piece.split("](").skip(1)).filter_map(|rest| rest.split(')').next()).collect()
}

/// The anchors of a document's headings, as they are made of the words.
fn anchors(text: &str) -> HashSet<String> {
    let prose = text.split("\n```").step_by(2);
    let headings = prose.flat_map(str::lines).filter(|line| line.starts_with('#'));
    let anchor = |heading: &str| {
        let words = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = words.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

/// The links of a document that lead nowhere.
fn broken(document: &Path) -> Vec<String> {
    let text = fs::read_to_string(document).unwrap();
    let leads_nowhere = |link: &&str| {
        let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
        let target =
            if file.is_empty() { document.to_owned() } else { document.parent().unwrap().join(file) };
        let is_found =
            || anchor.is_empty() || anchors(&fs::read_to_string(&target).unwrap()).contains(anchor);
        let is_elsewhere = link.contains("://");
        !is_elsewhere && (!target.exists() || !is_found())
    };
    let place = document.strip_prefix(root()).unwrap_or(document).display();
    links(&text).into_iter().filter(leads_nowhere).map(|link| format!("{place}: {link}")).collect()
}

#[test]
fn links_lead_somewhere() {
    let mut documents = Vec::new();
    files(&root(), ".md", &mut documents);
    let lost: Vec<String> = documents.iter().flat_map(|document| broken(document)).collect();
    assert!(lost.is_empty(), "links that lead nowhere:\n{}", lost.join("\n"));
}

#[test]
fn a_link_that_leads_nowhere_is_found() {
    let page = Path::new(env!("CARGO_TARGET_TMPDIR")).join("page.md");
    fs::write(
        &page,
        "# One two\n\n[a](#one-two) [b](#three) [c](none.md) [d](page.md#one-two) [e](https://f.g)\n",
    )
    .unwrap();
    let found = broken(&page);
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].ends_with("#three") && found[1].ends_with("none.md"), "{found:?}");
}

#[test]
fn the_book_has_all_its_pages() {
    let docs = root().join("docs");
    let mut pages = Vec::new();
    files(&docs, ".md", &mut pages);
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).unwrap();
    let listed: HashSet<&str> = links(&summary).into_iter().collect();
    let names = pages.iter().map(|page| page.strip_prefix(&docs).unwrap().to_str().unwrap());
    let missing: Vec<&str> = names.filter(|page| *page != "SUMMARY.md" && !listed.contains(page)).collect();
    assert!(missing.is_empty(), "not in docs/SUMMARY.md: {missing:?}");
}
