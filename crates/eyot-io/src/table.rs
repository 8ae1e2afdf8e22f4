//! Tables of numbers as CSV and Parquet.

use crate::atomic::write_atomically;
use crate::error::{Error, Result};
use eyot_core::component;
use parquet::basic::{Compression, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{DoubleType, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use serde_json::{Map, Value, json};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

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
        let column = |c: &component::Attribute| Column {
            name: c.name.clone(),
            unit: c.unit.clone(),
            is_whole: c.values.of().is_whole(),
            values: (0..table.len()).map(|i| c.values.number(i)).collect(),
        };
        Self { columns: table.columns().iter().map(column).collect(), about }
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

/// Writes a table as Apache Parquet: one group of rows, compressed with Zstandard. The file's metadata `eyot` is JSON: what
/// [`Table::about`] holds, and under `columns` the unit of each column.
///
/// # Errors
/// If columns differ in length or a name stands there twice; if the file cannot be written.
pub fn write_parquet(path: &Path, table: &Table) -> Result<()> {
    let rows = table.rows();
    let twice = |c: &Column| table.columns.iter().filter(|o| o.name == c.name).count() > 1;
    if let Some(c) = table.columns.iter().find(|c| c.values.len() != rows || twice(c)) {
        let problem = format!("column `{}` has {} of {rows} rows, or is there twice", c.name, c.values.len());
        return Err(Error::format(path, problem, "give each column a name of its own and equally many numbers"));
    }
    let bytes =
        encode(table).map_err(|e| Error::format(path, format!("the table cannot be encoded: {e}"), "use CSV"))?;
    write_atomically(path, |file| file.write_all(&bytes).map_err(Error::io(path, "write")))
}

fn encode(table: &Table) -> parquet::errors::Result<Vec<u8>> {
    let field = |c: &Column| {
        let physical = if c.is_whole { Physical::INT64 } else { Physical::DOUBLE };
        let field = Type::primitive_type_builder(&c.name, physical).with_repetition(Repetition::REQUIRED);
        field.build().map(Arc::new)
    };
    let fields = table.columns.iter().map(field).collect::<parquet::errors::Result<Vec<_>>>()?;
    let schema = Arc::new(Type::group_type_builder("table").with_fields(fields).build()?);
    let mut about = table.about.clone();
    let units: Map<String, Value> = table.columns.iter().map(|c| (c.name.clone(), json!({ "unit": c.unit }))).collect();
    about.insert("columns".to_owned(), Value::Object(units));
    let properties = WriterProperties::builder()
        .set_created_by(format!("Eyot {}", env!("CARGO_PKG_VERSION")))
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_key_value_metadata(Some(vec![KeyValue::new("eyot".to_owned(), Value::Object(about).to_string())]))
        .build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for column in &table.columns {
        let Some(mut to) = group.next_column()? else { break };
        if column.is_whole {
            let whole: Vec<i64> = column.values.iter().map(|v| *v as i64).collect();
            to.typed::<Int64Type>().write_batch(&whole, None, None)?;
        } else {
            to.typed::<DoubleType>().write_batch(&column.values, None, None)?;
        }
        to.close()?;
    }
    group.close()?;
    writer.close()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;

    fn table() -> Table {
        let column = |name: &str, unit: &str, is_whole, values: &[f64]| Column {
            name: name.into(),
            unit: unit.into(),
            is_whole,
            values: values.to_vec(),
        };
        let about = json!({ "seed": 7 }).as_object().unwrap().clone();
        let columns = vec![
            column("month", "month", true, &[0.0, 1.0, 2.0]),
            column("porites.cover", "1", false, &[0.1, f64::NAN, 1.0 / 3.0]),
        ];
        Table { columns, about }
    }

    #[test]
    fn tables_come_back_from_csv_and_parquet() {
        assert_eq!(table().csv(), "month,porites.cover\n0,0.1\n1,NaN\n2,0.3333333333333333\n");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.parquet");
        write_parquet(&path, &table()).unwrap();
        let reader = SerializedFileReader::new(std::fs::File::open(&path).unwrap()).unwrap();
        let rows: Vec<(i64, f64)> = reader
            .get_row_iter(None)
            .unwrap()
            .map(|row| row.unwrap())
            .map(|row| (row.get_long(0).unwrap(), row.get_double(1).unwrap()))
            .collect();
        assert_eq!((rows[0], rows[2], rows[1].0), ((0, 0.1), (2, 1.0 / 3.0), 1));
        assert!(rows.len() == 3 && rows[1].1.is_nan());
        let about = reader.metadata().file_metadata().key_value_metadata().unwrap()[0].clone();
        let about: Value = serde_json::from_str(&about.value.unwrap()).unwrap();
        assert_eq!((&about["seed"], &about["columns"]["month"]["unit"]), (&json!(7), &json!("month")));
        // The same table is the same bytes.
        assert_eq!(encode(&table()).unwrap(), std::fs::read(&path).unwrap());
    }

    #[test]
    fn uneven_tables_are_refused_before_a_file_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.parquet");
        let mut uneven = table();
        uneven.columns[1].values.pop();
        assert!(write_parquet(&path, &uneven).unwrap_err().to_string().contains("porites.cover"));
        let mut twice = table();
        twice.columns[1].name = "month".into();
        assert!(write_parquet(&path, &twice).unwrap_err().to_string().contains("twice"));
        assert!(!path.exists());
    }
}
