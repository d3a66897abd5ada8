//! Tables as Markdown.

use std::fmt;

/// A table with a heading over it; numbers are to the right.
pub struct Table {
    heading: String,
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table without rows.
    pub fn new(heading: impl Into<String>, columns: impl IntoIterator<Item = impl Into<String>>) -> Self {
        let columns = columns.into_iter().map(Into::into).collect();
        Self { heading: heading.into(), columns, rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = impl Into<String>>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }
}

impl fmt::Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n", self.heading)?;
        writeln!(f, "| {} |", self.columns.join(" | "))?;
        let rest = self.columns.len().saturating_sub(1);
        writeln!(f, "| --- |{}", " ---: |".repeat(rest))?;
        self.rows.iter().try_for_each(|row| writeln!(f, "| {} |", row.join(" | ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_laid_out() {
        let mut table = Table::new("Gaps", ["mesh", "gap"]);
        table.row(["fine", "0.1"]);
        assert_eq!(table.to_string(), "Gaps\n\n| mesh | gap |\n| --- | ---: |\n| fine | 0.1 |\n");
    }
}
