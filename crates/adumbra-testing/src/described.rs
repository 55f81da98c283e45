//! Checks printed JSON against a JSON Schema. Supports the part of draft 2020-12 that `schemars` writes.

use std::collections::BTreeSet;

use serde_json::Value;

/// Checks that `schema` describes `value`, and that it describes every field of it.
///
/// # Panics
///
/// Panics with the path in `value` that is not described, or with an unknown keyword of the schema.
pub fn assert_described(schema: &Value, value: &Value) {
    if let Err(what) = (Check { root: schema }).value(schema, value, "$") {
        panic!("{what}\n{schema:#}\n{value:#}");
    }
}

/// Returns the paths of the fields of a schema that have no description.
pub fn undescribed_fields(schema: &Value) -> Vec<String> {
    let mut found = Vec::new();
    collect_undescribed(schema, "$", &mut found);
    found
}

fn collect_undescribed(schema: &Value, place: &str, found: &mut Vec<String>) {
    for (key, below) in children(schema) {
        let place = format!("{place}.{key}");
        if key == "properties" {
            for (name, field) in children(below) {
                // The tag of an enumeration's variant is described by the variant.
                if field["description"].is_null() && schema["description"].is_null() {
                    found.push(format!("{place}.{name}"));
                }
                collect_undescribed(field, &format!("{place}.{name}"), found);
            }
        } else {
            collect_undescribed(below, &place, found);
        }
    }
}

fn children(value: &Value) -> Vec<(String, &Value)> {
    match value {
        Value::Object(fields) => fields.iter().map(|(key, value)| (key.clone(), value)).collect(),
        Value::Array(items) => (0..).zip(items).map(|(i, value): (u32, _)| (i.to_string(), value)).collect(),
        _ => Vec::new(),
    }
}

/// Keywords that do not constrain a value.
const ANNOTATIONS: [&str; 6] = ["$schema", "$defs", "title", "description", "format", "default"];

struct Check<'a> {
    root: &'a Value,
}

impl Check<'_> {
    fn value(&self, schema: &Value, value: &Value, place: &str) -> Result<(), String> {
        if *schema == Value::Bool(true) {
            return Ok(());
        }
        let Some(keywords) = schema.as_object() else { return Err(format!("{place}: no schema: {schema}")) };
        for (keyword, wanted) in keywords {
            let holds = match keyword.as_str() {
                "$ref" => {
                    let pointer = wanted.as_str().and_then(|text| text.strip_prefix('#'));
                    let Some(target) = pointer.and_then(|pointer| self.root.pointer(pointer)) else {
                        return Err(format!("{place}: {wanted} is not in the schema"));
                    };
                    self.value(target, value, place)?;
                    true
                }
                "type" => match wanted {
                    Value::Array(types) => types.iter().any(|name| has_type(name, value)),
                    name => has_type(name, value),
                },
                "const" => wanted == value,
                "enum" => list(wanted).contains(value),
                "oneOf" | "anyOf" => {
                    let fits = |s: &&Value| self.value(s, value, place).is_ok();
                    let number = list(wanted).iter().filter(fits).count();
                    number == 1 || (number > 1 && keyword == "anyOf")
                }
                "allOf" => {
                    list(wanted).iter().try_for_each(|s| self.value(s, value, place)).map(|()| true)?
                }
                "minimum" => value.as_f64().is_none_or(|v| wanted.as_f64().is_some_and(|least| v >= least)),
                "maximum" => value.as_f64().is_none_or(|v| wanted.as_f64().is_some_and(|most| v <= most)),
                "minItems" => {
                    value.as_array().is_none_or(|v| wanted.as_u64().is_some_and(|n| v.len() as u64 >= n))
                }
                "maxItems" => {
                    value.as_array().is_none_or(|v| wanted.as_u64().is_some_and(|n| v.len() as u64 <= n))
                }
                "items" => {
                    for (i, item) in list(value).iter().enumerate() {
                        self.value(wanted, item, &format!("{place}[{i}]"))?;
                    }
                    true
                }
                "prefixItems" => {
                    for (i, (part, item)) in list(wanted).iter().zip(list(value)).enumerate() {
                        self.value(part, item, &format!("{place}[{i}]"))?;
                    }
                    true
                }
                "required" => value.as_object().is_none_or(|fields| {
                    list(wanted).iter().filter_map(Value::as_str).all(|name| fields.contains_key(name))
                }),
                // The fields are checked below.
                "properties" | "additionalProperties" => true,
                name if ANNOTATIONS.contains(&name) => true,
                _ => return Err(format!("{place}: the keyword {keyword} is not known")),
            };
            if !holds {
                return Err(format!("{place}: {value} does not fit {keyword} {wanted}"));
            }
        }
        self.fields(schema, value, place)
    }

    /// Checks the fields of an object. A field without a description is an error, although JSON Schema itself
    /// allows it.
    fn fields(&self, schema: &Value, value: &Value, place: &str) -> Result<(), String> {
        let Some(fields) =
            value.as_object().filter(|_| schema["type"] == "object" || schema.get("properties").is_some())
        else {
            return Ok(());
        };
        // A reference or a choice beside the properties describes the fields of flattened types.
        let elsewhere = ["$ref", "oneOf", "anyOf", "allOf"].iter().any(|key| schema.get(key).is_some());
        let mut unknown = BTreeSet::new();
        for (name, field) in fields {
            match (schema["properties"].get(name), schema.get("additionalProperties")) {
                (Some(described), _) => self.value(described, field, &format!("{place}.{name}"))?,
                (None, Some(any)) => self.value(any, field, &format!("{place}.{name}"))?,
                (None, None) => {
                    unknown.insert(name);
                }
            }
        }
        if unknown.is_empty() || elsewhere {
            Ok(())
        } else {
            Err(format!("{place}: {unknown:?} are not in the schema"))
        }
    }
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn has_type(name: &Value, value: &Value) -> bool {
    match name.as_str().unwrap_or_default() {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        _ => false,
    }
}
