//! Names that a person or a file gave: in messages, and looked up where they are misspelt.
//!
//! A message shows them in one line of limited length, whatever is in them: a line's end would let a file forge a message of its
//! own, and other control characters would speak to the terminal.

use std::fmt::{self, Display, Write};

/// Characters of a name that a message shows.
const LONGEST: usize = 80;
/// Names that a list shows.
const MOST: usize = 20;
/// Characters of a name beyond which nobody has misspelt another one. It bounds the time that comparing takes.
const LONGEST_SLIP: usize = 80;

/// A name as a message shows it: shortened, and with escapes for what is no printable character; with `{:?}` also in quotes.
#[derive(Clone, Copy)]
pub struct Shown<'a>(&'a str);

/// A name for a message.
pub fn shown(name: &(impl AsRef<str> + ?Sized)) -> Shown<'_> {
    Shown(name.as_ref())
}

impl Shown<'_> {
    /// The part that is shown, and whether it is all.
    fn beginning(&self) -> (&str, bool) {
        match self.0.char_indices().nth(LONGEST) {
            Some((end, _)) => (&self.0[..end], false),
            None => (self.0, true),
        }
    }
}

impl Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (text, is_all) = self.beginning();
        f.write_str(&escaped(text))?;
        f.write_str(if is_all { "" } else { "…" })
    }
}

impl fmt::Debug for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (text, is_all) = self.beginning();
        if is_all { write!(f, "{text:?}") } else { write!(f, "{:?}", format!("{text}…")) }
    }
}

/// A text in one line, with escapes for what is no printable character. Quotes and backslashes stay what they are.
pub fn escaped(text: &str) -> String {
    let mut line = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '\'' | '"' | '\\' => line.push(letter),
            // Combining characters are escaped only where there is nothing to combine with, which is no danger.
            _ if letter.is_alphanumeric() => line.push(letter),
            _ => {
                let _ = write!(line, "{}", letter.escape_debug());
            }
        }
    }
    line
}

/// The beginning of a list, and how many there are besides.
pub fn list<S: Display>(names: impl IntoIterator<Item = S>) -> String {
    let mut names = names.into_iter();
    let mut text = String::new();
    for (k, name) in names.by_ref().take(MOST).enumerate() {
        let _ = write!(text, "{}{name}", if k == 0 { "" } else { ", " });
    }
    match names.count() {
        0 => text,
        more => format!("{text} and {more} more"),
    }
}

/// The name among `available` closest in spelling to `name`, if it is close enough to be a slip: at most one
/// edit for every three letters, letter case not counted.
pub fn nearest<'a>(name: &str, available: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let length = |text: &str| text.chars().take(LONGEST_SLIP + 1).count();
    let written = length(name);
    if written > LONGEST_SLIP {
        return None;
    }
    let wanted = name.to_lowercase();
    let allowed = (written / 3).max(1);
    available
        .into_iter()
        // So many edits are needed for the lengths alone.
        .filter(|candidate| length(candidate).abs_diff(written) <= allowed)
        .map(|candidate| (edit_distance(&wanted, &candidate.to_lowercase()), candidate))
        .filter(|&(distance, _)| distance <= allowed)
        .min()
        .map(|(_, candidate)| candidate)
}

/// The names in the order in which a list is of use to who wrote `name`: the closest spellings first, and names that Gmsh makes up last.
pub fn closest_first<'a>(name: &str, available: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let is_long = |text: &str| text.chars().nth(LONGEST_SLIP).is_some();
    let (wanted, wanted_is_long) = (name.to_lowercase(), is_long(name));
    let wanted_is_made_up = is_made_up(name);
    let key = |other: &str| {
        let distance =
            (!wanted_is_long && !is_long(other)).then(|| edit_distance(&wanted, &other.to_lowercase()));
        (is_made_up(other) && !wanted_is_made_up, distance.unwrap_or(usize::MAX))
    };
    let mut sorted: Vec<&str> = available.into_iter().collect();
    sorted.sort_by_cached_key(|&other| (key(other), other));
    sorted
}

/// Whether Gmsh or meshio makes up such a name where there is no other: `Surface5`, `PhysicalVolume2`, `gmsh:physical`.
fn is_made_up(name: &str) -> bool {
    let name = name.to_lowercase();
    let kind = name.trim_end_matches(|letter: char| letter.is_ascii_digit());
    let of_entity = kind.strip_prefix("physical").unwrap_or(kind).trim_end();
    let is_entity = ["point", "line", "curve", "surface", "volume"].contains(&of_entity);
    (is_entity && kind.len() < name.len()) || name.starts_with("gmsh:")
}

/// Insertions, deletions, replacements and swaps of neighbours that turn one text into the other (optimal
/// string alignment).
fn edit_distance(from: &str, to: &str) -> usize {
    let to: Vec<char> = to.chars().collect();
    let from: Vec<char> = from.chars().collect();
    let mut before_last = vec![0; to.len() + 1];
    let mut last: Vec<usize> = (0..=to.len()).collect();
    for i in 0..from.len() {
        let mut row = vec![i + 1];
        for j in 0..to.len() {
            let replaced = last[j] + usize::from(from[i] != to[j]);
            let mut least = replaced.min(last[j + 1] + 1).min(row[j] + 1);
            if i > 0 && j > 0 && from[i] == to[j - 1] && from[i - 1] == to[j] {
                least = least.min(before_last[j - 1] + 1);
            }
            row.push(least);
        }
        before_last = std::mem::replace(&mut last, row);
    }
    last[to.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances() {
        for (from, to, distance) in [
            ("", "", 0),
            ("", "abc", 3),
            ("master", "mastre", 1),
            ("slave", "salve", 1),
            ("kitten", "sitting", 3),
        ] {
            assert_eq!(edit_distance(from, to), distance, "{from} {to}");
            assert_eq!(edit_distance(to, from), distance, "{to} {from}");
        }
    }

    #[test]
    fn only_slips_are_suggested() {
        let names = ["master", "slave"];
        assert_eq!(nearest("Mastr", names), Some("master"));
        assert_eq!(nearest("salve", names), Some("slave"));
        assert_eq!(nearest("plate", names), None);
        assert_eq!(nearest("master", []), None);
    }

    #[test]
    fn lists_begin_with_the_closest_and_end_with_what_gmsh_makes_up() {
        let long = "a".repeat(10_000_000);
        let names = [
            "PhysicalSurface4",
            "Surface1",
            "Up-1",
            "bottom",
            "gmsh:bounding_entities",
            "surface 3",
            "surface",
            "top",
            &long,
        ];
        let [first, .., last] = closest_first("Upp", names)[..] else { panic!() };
        assert_eq!([first, last], ["Up-1", "gmsh:bounding_entities"]);
        assert_eq!(closest_first("tip", names)[..3], ["top", "Up-1", "bottom"]);
        assert_eq!(closest_first("tip", names)[5..8], ["Surface1", "surface 3", "PhysicalSurface4"]);
        // Asked for, they are no worse than others.
        assert_eq!(closest_first("Surface2", names)[0], "Surface1");
        assert_eq!(closest_first(&long, names).len(), names.len());
    }

    /// Comparing two of them letter by letter would take a day.
    #[test]
    fn long_names_are_nobodys_slips() {
        let long = "a".repeat(10_000_000);
        assert_eq!(nearest(&long, [long.as_str()]), None);
        assert_eq!(nearest("slave", [long.as_str(), "salve"]), Some("salve"));
    }

    #[test]
    fn names_are_shown_in_one_line_of_limited_length() {
        let hostile = "a\u{1b}]0;title\u{7}\nerror: forged \"é\" \u{202e}";
        let plain = shown(hostile).to_string();
        assert_eq!(plain, "a\\u{1b}]0;title\\u{7}\\nerror: forged \"é\" \\u{202e}");
        assert_eq!(format!("{:?}", shown("a \"b\"\n")), "\"a \\\"b\\\"\\n\"");
        let long = "é".repeat(1000);
        assert_eq!(shown(&long).to_string().chars().count(), LONGEST + 1);
        assert_eq!(format!("{:?}", shown(&long)).chars().count(), LONGEST + 3);
    }

    #[test]
    fn long_lists_end_with_a_number() {
        assert_eq!(list([1, 2, 3]), "1, 2, 3");
        assert_eq!(list([0; 0]), "");
        let many = list(0..3000);
        assert!(many.ends_with("18, 19 and 2980 more"), "{many}");
    }
}
