//! The verb `schema`: prints the JSON Schema of the JSON that another verb prints or writes.
//!
//! A program lists its schemas as [`Described`].

use schemars::generate::SchemaSettings;
use schemars::{JsonSchema, Schema};
use serde_json::Value;

use crate::exit::{Code, Failure, Outcome};
use crate::say;

/// The arguments of `schema`.
#[derive(clap::Args)]
pub struct SchemaArgs {
    /// What to describe, in the words of the list that is printed without any
    #[arg(value_name = "VERB")]
    pub words: Vec<String>,
}

/// JSON that has a schema.
pub struct Described {
    /// Its name: the verb that prints it, or the file that a verb reads.
    pub name: &'static str,
    /// Its description in the list of names.
    pub about: &'static str,
    root: fn() -> Schema,
}

impl Described {
    /// JSON that is a serialised `T`.
    pub const fn of<T: JsonSchema>(name: &'static str, about: &'static str) -> Self {
        Self {
            name,
            about,
            root: || {
                SchemaSettings::draft2020_12().for_serialize().into_generator().into_root_schema_for::<T>()
            },
        }
    }

    /// Returns the schema, of draft 2020-12. Its descriptions are plain text.
    pub fn schema(&self) -> Value {
        let mut schema = (self.root)().to_value();
        simplify_descriptions(&mut schema);
        schema
    }
}

impl SchemaArgs {
    /// Prints the schema of the given name, or all names.
    ///
    /// # Errors
    ///
    /// Returns [`Failure::Usage`] with the names if there is no such name.
    pub fn run(&self, described: &[Described]) -> Outcome {
        let width = described.iter().map(|d| d.name.len()).max().unwrap_or_default();
        if self.words.is_empty() {
            for Described { name, about, .. } in described {
                say!("{name:width$}  {about}");
            }
            return Ok(Code::Fine);
        }
        // One name may be given as several words or in quotes.
        let asked = self.words.join(" ");
        let Some(found) = described.iter().find(|d| d.name == asked) else {
            let names: Vec<&str> = described.iter().map(|d| d.name).collect();
            return Err(Failure::Usage(format!(
                "there is no schema of {asked:?}; give one of: {}",
                names.join(", ")
            )));
        };
        say!("{:#}", found.schema());
        Ok(Code::Fine)
    }
}

/// Turns the links of documentation comments into names, and Rust's `None` into JSON's null.
fn simplify_descriptions(schema: &mut Value) {
    match schema {
        Value::Object(fields) => {
            for (key, value) in fields {
                match value {
                    Value::String(text) if key == "description" => *text = plain(text),
                    other => simplify_descriptions(other),
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(simplify_descriptions),
        _ => {}
    }
}

fn plain(text: &str) -> String {
    let mut plain = String::new();
    let mut rest = text;
    while let Some((before, from_name)) = rest.split_once("[`")
        && let Some((name, after)) = from_name.split_once("`]")
    {
        plain += &format!("{before}`{name}`");
        let target = after.strip_prefix('(').and_then(|target| target.split_once(')'));
        rest = target.map_or(after, |(_, after)| after);
    }
    plain += rest;
    plain.split_whitespace().collect::<Vec<_>>().join(" ").replace("`None`", "null")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn descriptions_turn_links_into_names() {
        let text = "See [`A`] and\n[`b`](crate::b). `None` (of [c]) if there is none.";
        assert_eq!(plain(text), "See `A` and `b`. null (of [c]) if there is none.");
    }

    #[test]
    fn rejects_unknown_names_and_lists_known_ones() {
        let described = [Described::of::<u32>("tree bake", "A."), Described::of::<bool>("dag bake", "B.")];
        let run = |words: &[&str]| {
            SchemaArgs { words: words.iter().map(|&word| word.to_owned()).collect() }.run(&described)
        };
        assert!(run(&[]).is_ok() && run(&["tree", "bake"]).is_ok() && run(&["tree bake"]).is_ok());
        let Err(error) = run(&["tree"]) else { panic!("it is not a name") };
        assert_eq!(error.to_string(), "there is no schema of \"tree\"; give one of: tree bake, dag bake");
    }
}
