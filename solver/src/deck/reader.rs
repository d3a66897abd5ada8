//! TOML with places: every value knows its line and its full name.

use std::ops::Range;
use std::path::Path;

use diffuse_contact_mesh::names::{nearest, shown};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::{DeckError, Problem};

/// A text and where it came from.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub text: &'a str,
    pub path: &'a Path,
}

impl Source<'_> {
    pub fn line(&self, at: usize) -> usize {
        1 + self.text.bytes().take(at).filter(|&byte| byte == b'\n').count()
    }

    pub fn error(&self, at: usize, problem: Problem) -> DeckError {
        let (path, line) = (self.path.to_path_buf(), self.line(at));
        DeckError::Invalid { path, line, problem: Box::new(problem) }
    }
}

/// A table whose fields are all known.
#[derive(Clone)]
pub(super) struct Section<'a> {
    pub source: Source<'a>,
    /// For messages, such as `[parts.pipe]`.
    name: String,
    /// What stands before the name of a field, with its dot.
    prefix: String,
    at: usize,
    table: &'a DeTable<'a>,
}

impl<'a> Section<'a> {
    /// A whole deck.
    pub fn root(source: Source<'a>, table: &'a Spanned<DeTable<'a>>) -> Self {
        Self { source, name: "the deck".into(), prefix: String::new(), at: 0, table: table.get_ref() }
    }

    /// Refuses fields other than these.
    pub fn expect(self, known: &[&str]) -> Result<Self, DeckError> {
        let unknown = self.table.keys().filter(|key| !known.contains(&key.get_ref().as_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else { return Ok(self) };
        let is_table = self.get(key.get_ref()).is_some_and(|found| found.holds_tables());
        let what = if is_table { "table" } else { "field" };
        let field = key.get_ref().to_string();
        let nearest = nearest(&field, known.iter().copied()).map(str::to_owned);
        let known = known.iter().map(|name| name.to_string()).collect();
        let table = self.name.clone();
        Err(self.source.error(key.span().start, Problem::UnknownField { table, what, field, nearest, known }))
    }

    /// The field, if it is there.
    pub fn get(&self, field: &str) -> Option<Field<'a>> {
        let (_, value) = self.table.iter().find(|(key, _)| key.get_ref().as_ref() == field)?;
        let name = format!("{}{}", self.prefix, shown(field));
        Some(Field { source: self.source, name, at: value.span(), value: value.get_ref() })
    }

    /// What a field says, or this where it is not there.
    pub fn or<T>(
        &self,
        field: &str,
        default: T,
        read: impl FnOnce(&Field<'a>) -> Result<T, DeckError>,
    ) -> Result<T, DeckError> {
        self.get(field).map_or(Ok(default), |field| read(&field))
    }

    /// Takes over what a field says, if it is there.
    pub fn set<T>(
        &self,
        field: &str,
        value: &mut T,
        read: impl FnOnce(&Field<'a>) -> Result<T, DeckError>,
    ) -> Result<(), DeckError> {
        if let Some(field) = self.get(field) {
            *value = read(&field)?;
        }
        Ok(())
    }

    /// The field.
    pub fn need(&self, field: &'static str) -> Result<Field<'a>, DeckError> {
        self.need_what("field", field)
    }

    /// The field, which is a table.
    pub fn need_table(&self, field: &'static str) -> Result<Field<'a>, DeckError> {
        self.need_what("table", field)
    }

    fn need_what(&self, what: &'static str, field: &'static str) -> Result<Field<'a>, DeckError> {
        let missing = || self.error(Problem::Missing { table: self.name.clone(), what, field });
        self.get(field).ok_or_else(missing)
    }

    /// All fields in the order of the text.
    pub fn all(&self) -> Vec<(String, Field<'a>)> {
        let mut keys: Vec<_> = self.table.keys().collect();
        keys.sort_by_key(|key| key.span().start);
        keys.iter().filter_map(|key| Some((key.get_ref().to_string(), self.get(key.get_ref())?))).collect()
    }

    /// The first of these fields that is there beside another makes no sense.
    pub fn refuse(&self, fields: &[&str], reason: &'static str) -> Result<(), DeckError> {
        match fields.iter().find_map(|field| self.get(field)) {
            Some(field) => Err(field.error(Problem::Meaningless { field: field.name.clone(), reason })),
            None => Ok(()),
        }
    }

    /// Several fields of which none is there.
    pub fn incomplete(&self, fields: &'static str) -> DeckError {
        self.error(Problem::Incomplete { table: self.name.clone(), fields })
    }

    pub fn error(&self, problem: Problem) -> DeckError {
        self.source.error(self.at, problem)
    }

    pub fn line(&self) -> usize {
        self.source.line(self.at)
    }
}

/// A value with its full name.
#[derive(Clone)]
pub(super) struct Field<'a> {
    source: Source<'a>,
    name: String,
    at: Range<usize>,
    value: &'a DeValue<'a>,
}

impl<'a> Field<'a> {
    pub fn error(&self, problem: Problem) -> DeckError {
        self.source.error(self.at.start, problem)
    }

    pub fn name(&self) -> &str {
        &self.name
    }

    pub fn line(&self) -> usize {
        self.source.line(self.at.start)
    }

    pub fn wrong_type(&self, expected: impl Into<String>) -> DeckError {
        let found = match self.value {
            DeValue::Array(items) => format!("a list of {}", items.len()),
            DeValue::Table(_) => "a table".into(),
            DeValue::String(text) => format!("the text {:?}", shown(text)),
            _ => shown(self.source.text.get(self.at.clone()).unwrap_or("something else")).to_string(),
        };
        self.error(Problem::WrongType { field: self.name.clone(), expected: expected.into(), found })
    }

    pub fn out_of_range(&self, range: &'static str, value: f64) -> DeckError {
        self.error(Problem::OutOfRange { field: self.name.clone(), range, value })
    }

    /// A finite number.
    pub fn number(&self) -> Result<f64, DeckError> {
        let value = match self.value {
            // TOML's underscores are gone from the text here. An integer may be written in another base.
            DeValue::Integer(integer) => {
                i128::from_str_radix(integer.as_str(), integer.radix()).ok().map(|n| n as f64)
            }
            DeValue::Float(float) => float.as_str().parse::<f64>().ok(),
            _ => None,
        };
        match value {
            Some(value) if value.is_finite() => Ok(value),
            Some(value) => Err(self.out_of_range("finite", value)),
            None => Err(self.wrong_type("a number")),
        }
    }

    /// A number for which `holds`; `range` says so in words.
    pub fn number_in(&self, range: &'static str, holds: impl Fn(f64) -> bool) -> Result<f64, DeckError> {
        let value = self.number()?;
        if holds(value) { Ok(value) } else { Err(self.out_of_range(range, value)) }
    }

    pub fn positive(&self) -> Result<f64, DeckError> {
        self.number_in("positive", |value| value > 0.0)
    }

    /// A whole number from 0 on.
    pub fn count(&self) -> Result<usize, DeckError> {
        let DeValue::Integer(integer) = self.value else { return Err(self.wrong_type("a whole number")) };
        let value = i128::from_str_radix(integer.as_str(), integer.radix()).ok();
        match value.and_then(|value| u32::try_from(value).ok()) {
            Some(count) => Ok(count as usize),
            None => {
                // There is nothing to count of which a deck could have none, or more than 32 bits can count.
                let value = value.map_or(f64::INFINITY, |value| value as f64);
                Err(self.out_of_range(if value < 0.0 { "at least 1" } else { "at most 4294967295" }, value))
            }
        }
    }

    /// A whole number from 1 on.
    pub fn positive_count(&self) -> Result<usize, DeckError> {
        match self.count()? {
            0 => Err(self.out_of_range("at least 1", 0.0)),
            count => Ok(count),
        }
    }

    pub fn flag(&self) -> Result<bool, DeckError> {
        self.value.as_bool().ok_or_else(|| self.wrong_type("true or false"))
    }

    pub fn text(&self) -> Result<String, DeckError> {
        self.value.as_str().map(String::from).ok_or_else(|| self.wrong_type("a text in quotes"))
    }

    /// The thing whose name this is.
    pub fn word<T: Copy>(&self, words: &[(&str, T)]) -> Result<T, DeckError> {
        let word = self.text()?;
        if let Some(&(_, found)) = words.iter().find(|(name, _)| *name == word) {
            return Ok(found);
        }
        let nearest = nearest(&word, words.iter().map(|&(name, _)| name)).map(str::to_owned);
        let known = words.iter().map(|(name, _)| format!("{name:?}")).collect();
        Err(self.error(Problem::UnknownWord { field: self.name.clone(), word, nearest, known }))
    }

    /// The same, where builds with a Cargo feature know more words.
    pub fn word_or_left_out<T: Copy>(
        &self,
        words: &[(&str, T)],
        (left_out, feature): (&[&str], &'static str),
    ) -> Result<T, DeckError> {
        let word = self.text()?;
        if left_out.contains(&word.as_str()) {
            return Err(self.error(Problem::LeftOut { field: self.name.clone(), word, feature }));
        }
        self.word(words)
    }

    /// The members of a list.
    pub fn list(&self, expected: &str) -> Result<Vec<Field<'a>>, DeckError> {
        let items = self.value.as_array().ok_or_else(|| self.wrong_type(expected))?;
        let member = |(k, item): (usize, &'a Spanned<DeValue<'a>>)| {
            let name = format!("{}[{}]", self.name, k + 1);
            Field { source: self.source, name, at: item.span(), value: item.get_ref() }
        };
        Ok(items.iter().enumerate().map(member).collect())
    }

    /// Exactly N members.
    pub fn tuple<const N: usize>(&self, expected: &str) -> Result<[Field<'a>; N], DeckError> {
        <[Field; N]>::try_from(self.list(expected)?).map_err(|_| self.wrong_type(expected))
    }

    /// N numbers.
    pub fn numbers<const N: usize>(&self, expected: &str) -> Result<[f64; N], DeckError> {
        let mut numbers = [0.0; N];
        for (number, field) in numbers.iter_mut().zip(self.tuple::<N>(expected)?) {
            *number = field.number()?;
        }
        Ok(numbers)
    }

    /// N whole numbers.
    pub fn counts<const N: usize>(&self, expected: &str) -> Result<[usize; N], DeckError> {
        let mut counts = [0; N];
        for (count, field) in counts.iter_mut().zip(self.tuple::<N>(expected)?) {
            *count = field.count()?;
        }
        Ok(counts)
    }

    /// A point or direction.
    pub fn vector(&self) -> Result<[f64; 3], DeckError> {
        self.numbers("a list of three numbers")
    }

    pub fn is_list(&self) -> bool {
        self.value.is_array()
    }

    pub fn is_table(&self) -> bool {
        self.value.is_table()
    }

    /// Whether this is a table or a list of tables.
    fn holds_tables(&self) -> bool {
        let is_table = |value: &DeValue| value.as_table().is_some();
        let are_tables = |items: &[Spanned<DeValue>]| {
            !items.is_empty() && items.iter().all(|item| is_table(item.get_ref()))
        };
        is_table(self.value) || self.value.as_array().is_some_and(|items| are_tables(items))
    }

    /// A table.
    pub fn section(&self) -> Result<Section<'a>, DeckError> {
        let table = self.value.as_table().ok_or_else(|| self.wrong_type("a table"))?;
        let (name, prefix) = (format!("[{}]", self.name), format!("{}.", self.name));
        Ok(Section { source: self.source, name, prefix, at: self.at.start, table })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_of_other_builds_is_refused_with_its_feature() {
        let read = |text: &str| {
            let table = DeTable::parse(text).unwrap();
            let (_, value) = table.get_ref().iter().next().unwrap();
            let source = Source { text, path: Path::new("deck.toml") };
            let (name, at) = ("interface[1].weight".to_owned(), value.span());
            let field = Field { source, name, at, value: value.get_ref() };
            field
                .word_or_left_out(&[("one", 1), ("two", 2)], (&["three"], "threes"))
                .map_err(|error| error.to_string())
        };
        assert_eq!(read("weight = \"two\""), Ok(2));
        let refused = read("\nweight = \"three\"").unwrap_err();
        let expected =
            "interface[1].weight cannot be \"three\" here: it needs a program built with --features threes";
        assert!(refused.contains(expected) && refused.contains("line 2"), "{refused}");
        assert!(read("weight = \"four\"").unwrap_err().contains("cannot be \"four\""));
    }
}
