//! Tables as Markdown.

use std::fmt::{self, Display};

/// A table with a heading over it; numbers are to the right. Between the cells of a row stands ` | `.
pub struct Table(String);

impl Table {
    /// A table without rows.
    pub fn new(heading: impl Display, columns: &str) -> Self {
        let rest = " ---: |".repeat(columns.matches(" | ").count());
        Self(format!("{heading}\n\n| {columns} |\n| --- |{rest}\n"))
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl Display) {
        self.0 += &format!("| {cells} |\n");
    }
}

impl Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Cells of a row, as many as there are.
pub fn cells(cells: impl IntoIterator<Item = String>) -> String {
    cells.into_iter().collect::<Vec<_>>().join(" | ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_laid_out() {
        let mut table = Table::new("Gaps", "mesh | gap");
        table.row("fine | 0.1");
        assert_eq!(table.to_string(), "Gaps\n\n| mesh | gap |\n| --- | ---: |\n| fine | 0.1 |\n");
    }
}
