//! PLY files from lists of values, as text and in both byte orders.

/// One element: its name, its properties as header lines without the keyword, and its records. A record is a
/// flat list of values, in which the number of items precedes each list.
#[derive(Clone, Debug)]
pub struct PlyElement {
    /// Its name.
    pub name: String,
    /// Its properties: "float x", "list uchar int vertex_indices".
    pub properties: Vec<String>,
    /// Its records. Each value belongs to a property.
    pub records: Vec<Vec<f64>>,
}

/// A PLY file.
#[derive(Clone, Debug, Default)]
pub struct Ply {
    /// Its elements, in their order.
    pub elements: Vec<PlyElement>,
}

/// The formats of a PLY file, as its header names them.
pub const PLY_FORMATS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

impl Ply {
    /// Adds an element.
    pub fn with(mut self, name: &str, properties: &[&str], records: &[&[f64]]) -> Self {
        self.elements.push(PlyElement {
            name: name.to_owned(),
            properties: properties.iter().map(|&p| p.to_owned()).collect(),
            records: records.iter().map(|r| r.to_vec()).collect(),
        });
        self
    }

    /// The header in one of [`PLY_FORMATS`].
    pub fn header(&self, format: &str) -> String {
        let mut out = format!("ply\nformat {format} 1.0\n");
        for element in &self.elements {
            out += &format!("element {} {}\n", element.name, element.records.len());
            element.properties.iter().for_each(|p| out += &format!("property {p}\n"));
        }
        out + "end_header\n"
    }

    /// The file in one of [`PLY_FORMATS`].
    pub fn bytes(&self, format: &str) -> Vec<u8> {
        let mut out = self.header(format).into_bytes();
        for element in &self.elements {
            for record in &element.records {
                if format == "ascii" {
                    let words: Vec<String> = record.iter().map(f64::to_string).collect();
                    out.extend((words.join(" ") + "\n").bytes());
                } else {
                    put_record(&mut out, &element.properties, record, format == "binary_big_endian");
                }
            }
        }
        out
    }
}

fn put_record(out: &mut Vec<u8>, properties: &[String], record: &[f64], big: bool) {
    let mut values = record.iter().copied();
    let mut next = || values.next().expect("the record has a value for each property");
    for property in properties {
        let words: Vec<&str> = property.split_whitespace().collect();
        if words[0] == "list" {
            let count = next();
            put(out, words[1], count, big);
            (0..count as usize).for_each(|_| put(out, words[2], next(), big));
        } else {
            put(out, words[0], next(), big);
        }
    }
    assert!(values.next().is_none(), "the record has a value too many");
}

/// Appends one value of a type.
fn put(out: &mut Vec<u8>, kind: &str, value: f64, big: bool) {
    let from = out.len();
    match kind {
        "char" | "int8" => out.extend((value as i8).to_le_bytes()),
        "uchar" | "uint8" => out.extend((value as u8).to_le_bytes()),
        "short" | "int16" => out.extend((value as i16).to_le_bytes()),
        "ushort" | "uint16" => out.extend((value as u16).to_le_bytes()),
        "int" | "int32" => out.extend((value as i32).to_le_bytes()),
        "uint" | "uint32" => out.extend((value as u32).to_le_bytes()),
        "int64" => out.extend((value as i64).to_le_bytes()),
        "uint64" => out.extend((value as u64).to_le_bytes()),
        "float" | "float32" => out.extend((value as f32).to_le_bytes()),
        "double" | "float64" => out.extend(value.to_le_bytes()),
        other => panic!("no type {other}"),
    }
    if big {
        out[from..].reverse();
    }
}
