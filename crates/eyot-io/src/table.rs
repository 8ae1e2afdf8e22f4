//! Tables of numbers, and their text as CSV.

use eyot_core::component::{self, Attributes, View};
use serde_json::{Map, Value};

/// A column of a [`Table`].
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name, once in a table.
    pub name: String,
    /// Unit of its numbers; `1` for plain ones.
    pub unit: String,
    /// True for whole numbers: 64-bit integers in Parquet instead of double precision.
    pub is_whole: bool,
    /// Its numbers; those of all columns are equally many.
    pub values: Vec<f64>,
}

/// A table: columns of equal length, and what is to be said about it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// From left to right.
    pub columns: Vec<Column>,
    /// Where it comes from, for formats that can hold that.
    pub about: Map<String, Value>,
}

impl Table {
    /// A table of a world, and what is to be said about it.
    pub fn of(table: &component::Table, about: Map<String, Value>) -> Self {
        Self { columns: columns(table).collect(), about }
    }

    /// What a component shows of itself, and what is to be said about it: of points a row for each with `x`, `y` and `z` first, of lines
    /// a row for each with the numbers of the nodes `from` and `to` first, of features their attributes. `None` for what has no rows.
    pub fn of_view(view: &View<'_>, about: Map<String, Value>) -> Option<Self> {
        let columns = match view {
            View::Table(table) => columns(table).collect(),
            View::Points(points) => {
                let along = |i: usize| points.positions().iter().map(|p| f64::from(p[i])).collect();
                let place = |(i, name): (usize, &str)| column(name, "m", false, along(i));
                ["x", "y", "z"].into_iter().enumerate().map(place).chain(columns(points.attributes())).collect()
            }
            View::Lines(graph) => {
                let end = |i: usize| graph.edges().iter().map(|e| f64::from(e[i])).collect();
                let node = |(i, name): (usize, &str)| column(name, "1", true, end(i));
                ["from", "to"].into_iter().enumerate().map(node).chain(columns(graph.edge_attributes())).collect()
            }
            View::Features(features) => columns(features.attributes()).collect(),
            _ => return None,
        };
        Some(Self { columns, about })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |c| c.values.len())
    }

    /// The table as comma-separated values: a line of names, then one for each row. Numbers are the shortest that are read back to
    /// the same bits.
    pub fn csv(&self) -> String {
        let names: Vec<&str> = self.columns.iter().map(|c| c.name.as_str()).collect();
        let mut out = names.join(",") + "\n";
        for row in 0..self.rows() {
            let cells: Vec<String> = self.columns.iter().map(|c| c.values[row].to_string()).collect();
            out.push_str(&cells.join(","));
            out.push('\n');
        }
        out
    }
}

fn column(name: &str, unit: &str, is_whole: bool, values: Vec<f64>) -> Column {
    Column { name: name.to_owned(), unit: unit.to_owned(), is_whole, values }
}

fn columns(attributes: &Attributes) -> impl Iterator<Item = Column> + '_ {
    attributes.columns().iter().map(|c| {
        let values = (0..attributes.len()).map(|i| c.values.number(i)).collect();
        column(&c.name, &c.unit, c.values.of().is_whole(), values)
    })
}
#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_the_shortest_of_their_bits() {
        let column = |name: &str, values: &[f64]| Column {
            name: name.into(),
            unit: "1".into(),
            is_whole: false,
            values: values.to_vec(),
        };
        let columns = vec![column("month", &[0.0, 1.0, 2.0]), column("porites.cover", &[0.1, f64::NAN, 1.0 / 3.0])];
        let table = Table { columns, about: Map::new() };
        assert_eq!(table.csv(), "month,porites.cover\n0,0.1\n1,NaN\n2,0.3333333333333333\n");
    }
}
