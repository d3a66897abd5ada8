//! Named sets of an Abaqus file: collected as written, resolved once all nodes and elements are known.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use crate::builder::MOST_MEMBERS;
use crate::error::{Fault, Problem};

/// So many numbers of a range, and as many again as there are members, may be those of nothing.
const MOST_GAPS: usize = 10_000;

/// Where a name is defined. A part and the model around it may use the same name for different sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Level {
    /// Inside `*PART` or `*INSTANCE`.
    Part,
    /// Elsewhere: in the assembly, or in a file without parts.
    Model,
}

/// What a data line puts into a set.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Member {
    /// The tags `first`, `first + step`, ... up to `last`.
    Tags { first: u64, last: u64, step: u64 },
    /// What the set with this number holds so far.
    Set(usize),
}

impl Member {
    pub fn tag(tag: u64) -> Self {
        Member::Tags { first: tag, last: tag, step: 1 }
    }

    /// How many members it stands for, missing ones as well.
    pub fn count(self, sets: &[Content]) -> usize {
        match self {
            Member::Set(number) => sets[number].indices.len(),
            Member::Tags { first, last, step } => {
                usize::try_from((last - first) / step).map_or(usize::MAX, |n| n.saturating_add(1))
            }
        }
    }
}

/// The names of one name space. Letter case does not count; the first spelling is kept.
#[derive(Default)]
pub(super) struct Names {
    numbers: HashMap<(Level, String), usize>,
    spellings: Vec<(Level, String)>,
}

impl Names {
    /// The number of the set of this name, which is created if there is none.
    pub fn define(&mut self, level: Level, name: &str) -> usize {
        *self.numbers.entry((level, name.to_uppercase())).or_insert_with(|| {
            self.spellings.push((level, name.to_string()));
            self.spellings.len() - 1
        })
    }

    pub fn find(&self, level: Level, name: &str) -> Option<usize> {
        self.numbers.get(&(level, name.to_uppercase())).copied()
    }

    /// How many names there are.
    pub fn count(&self) -> usize {
        self.spellings.len()
    }

    /// A set's name as it was first written.
    pub fn spelling(&self, number: usize) -> &str {
        &self.spellings[number].1
    }

    /// Names the sets for the outside: a part's set whose name the model uses too is qualified by the instance.
    pub fn publish<T>(&self, sets: Vec<T>, instance: &str) -> BTreeMap<String, T> {
        let public = |(level, name): &(Level, String)| match level {
            Level::Part if self.find(Level::Model, name).is_some() => format!("{instance}.{name}"),
            _ => name.clone(),
        };
        self.spellings.iter().map(public).zip(sets).collect()
    }
}

/// The sets of nodes, or the sets of elements.
pub(super) struct Sets {
    pub names: Names,
    /// `"node"` or `"element"`.
    pub of: &'static str,
    entries: Vec<Entry>,
    /// First members of sets that are no labels, and where they are, in the order of the file.
    pub wrong: Vec<(String, usize)>,
    /// Their places in the list, by set.
    wrong_in: BTreeMap<usize, usize>,
}

/// Why what is in a set cannot be told.
#[derive(Clone, Copy)]
pub(super) enum Unusable {
    /// It holds this element of a type that is not supported.
    Element(u64),
    /// It has this one of the members that are no labels, or holds a set that has.
    Label(usize),
}

/// What a tag stands for.
#[derive(Clone, Copy)]
pub(super) enum Found {
    /// A node or an element that was read.
    Index(usize),
    /// An element of a type that is not supported.
    Unread,
    /// Nothing; whether all numbers are smaller.
    Missing { is_beyond: bool },
}

/// What is in a set.
#[derive(Clone, Default)]
pub(super) struct Content {
    pub indices: BTreeSet<usize>,
    /// The first reason why this is not all of it.
    pub unread: Option<Unusable>,
}

impl Content {
    pub fn take(&mut self, (indices, unread): (Vec<usize>, Option<Unusable>)) {
        self.indices.extend(indices);
        self.unread = self.unread.or(unread);
    }
}

/// How many members there may still be, so that a small file cannot ask for any number.
pub(super) struct Room {
    left: usize,
    what: &'static str,
}

impl Room {
    /// For what `of` is the singular of.
    pub fn new(of: &str) -> Self {
        Self { left: MOST_MEMBERS, what: if of == "node" { "nodes" } else { "elements" } }
    }

    pub fn take(&mut self, members: usize, at: usize) -> Result<(), Fault> {
        let too_large = || Fault::new(at, Problem::SetsTooLarge { what: self.what, limit: MOST_MEMBERS });
        self.left = self.left.checked_sub(members).ok_or_else(too_large)?;
        Ok(())
    }
}

/// That a set, or a surface, has a member.
#[derive(Clone, Copy)]
pub(super) struct Entry {
    pub at: usize,
    pub set: usize,
    pub member: Member,
}

impl Sets {
    pub fn new(of: &'static str) -> Self {
        Self {
            names: Names::default(),
            of,
            entries: Vec::new(),
            wrong: Vec::new(),
            wrong_in: BTreeMap::new(),
        }
    }

    pub fn add(&mut self, set: usize, member: Member, at: usize) {
        self.entries.push(Entry { at, set, member });
    }

    pub fn add_wrong(&mut self, set: usize, label: String, at: usize) {
        self.wrong_in.entry(set).or_insert_with(|| {
            self.wrong.push((label, at));
            self.wrong.len() - 1
        });
    }

    /// What is in every set. `find` says what a tag stands for.
    pub fn resolve(&self, find: impl Fn(u64) -> Found) -> Result<Vec<Content>, Fault> {
        let mut sets = vec![Content::default(); self.names.count()];
        self.wrong_in.iter().for_each(|(&set, &wrong)| sets[set].unread = Some(Unusable::Label(wrong)));
        let mut room = Room::new(self.of);
        // The same once more adds nothing.
        let mut known = HashSet::new();
        // Other numbers of a set whose members are not labels mean nothing, either.
        for &entry in self.entries.iter().filter(|entry| !self.wrong_in.contains_key(&entry.set)) {
            if let Member::Tags { first, last, step } = entry.member
                && !known.insert((entry.set, first, last, step))
            {
                continue;
            }
            let members = self.members(entry, &self.names, &sets, &find)?;
            room.take(members.0.len(), entry.at)?;
            sets[entry.set].take(members);
        }
        Ok(sets)
    }

    /// The indices that a member stands for and the first reason why these are not all. `names`: of what has the member.
    pub fn members(
        &self,
        Entry { at, set, member }: Entry,
        names: &Names,
        sets: &[Content],
        find: impl Fn(u64) -> Found,
    ) -> Result<(Vec<usize>, Option<Unusable>), Fault> {
        match member {
            Member::Set(number) => Ok((sets[number].indices.iter().copied().collect(), sets[number].unread)),
            Member::Tags { first, last, step } => {
                // A range may have gaps, and go beyond the last number. A huge one costs little more than the mesh is large.
                let (mut indices, mut unread) = (Vec::new(), None);
                let (mut gaps, mut gap) = (0, None);
                let mut tag = first;
                while tag <= last {
                    match find(tag) {
                        Found::Index(index) => indices.push(index),
                        Found::Unread => unread = unread.or(Some(Unusable::Element(tag))),
                        Found::Missing { is_beyond } => {
                            gap = gap.or(Some(tag));
                            gaps += 1;
                            if is_beyond {
                                break;
                            }
                        }
                    }
                    match tag.checked_add(step).filter(|_| gaps <= MOST_GAPS + indices.len()) {
                        Some(next) => tag = next,
                        None => break,
                    }
                }
                if let Some(gap) = gap
                    && (indices.is_empty() && unread.is_none() || gaps > MOST_GAPS + indices.len())
                {
                    let (set, member) = (names.spelling(set).to_string(), format!("{} {gap}", self.of));
                    return Err(Fault::new(at, Problem::MissingMember { set, member }));
                }
                Ok((indices, unread))
            }
        }
    }
}
