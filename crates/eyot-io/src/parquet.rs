//! Tables as Apache Parquet.

use crate::atomic::put;
use crate::error::{Error, Result};
use crate::table::{Column, Table};
use crate::target::Target;
use ::parquet::basic::{Compression, Repetition, Type as Physical, ZstdLevel};
use ::parquet::data_type::{DoubleType, Int64Type};
use ::parquet::file::metadata::KeyValue;
use ::parquet::file::properties::WriterProperties;
use ::parquet::file::writer::SerializedFileWriter;
use ::parquet::schema::types::Type;
use serde_json::{Map, Value, json};
use std::sync::Arc;

/// Writes a table as Apache Parquet: one group of rows, compressed with Zstandard. The file's metadata `eyot` is JSON: what
/// [`Table::about`] holds, and under `columns` the unit of each column.
///
/// # Errors
/// If columns differ in length or a name stands there twice; if the file cannot be written.
pub fn write_parquet<'a>(to: impl Into<Target<'a>>, table: &Table) -> Result<()> {
    let to = to.into();
    let path = to.place();
    let rows = table.rows();
    let twice = |c: &Column| table.columns.iter().filter(|o| o.name == c.name).count() > 1;
    if let Some(c) = table.columns.iter().find(|c| c.values.len() != rows || twice(c)) {
        let problem = format!("column `{}` has {} of {rows} rows, or is there twice", c.name, c.values.len());
        return Err(Error::format(path, problem, "give each column a name of its own and equally many numbers"));
    }
    let bytes =
        encode(table).map_err(|e| Error::format(path, format!("the table cannot be encoded: {e}"), "use CSV"))?;
    to.write(|file| put(file, path, &bytes))
}

fn encode(table: &Table) -> ::parquet::errors::Result<Vec<u8>> {
    let field = |c: &Column| {
        let physical = if c.is_whole { Physical::INT64 } else { Physical::DOUBLE };
        let field = Type::primitive_type_builder(&c.name, physical).with_repetition(Repetition::REQUIRED);
        field.build().map(Arc::new)
    };
    let fields = table.columns.iter().map(field).collect::<::parquet::errors::Result<Vec<_>>>()?;
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
    use ::parquet::file::reader::{FileReader, SerializedFileReader};
    use ::parquet::record::RowAccessor;

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
    fn tables_come_back() {
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
