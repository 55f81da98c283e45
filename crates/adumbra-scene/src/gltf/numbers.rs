//! Whole numbers of glTF files. JSON does not distinguish `4` from `4.0` (RFC 8259, 6), and some programs
//! write the latter.

use serde_json::Value;

/// Whole numbers below this are exact in double precision.
const EXACT: f64 = (1_u64 << 53) as f64;

/// A whole number that is not negative, written as `4` or as `4.0`.
pub(super) fn whole(value: &Value) -> Option<u64> {
    let float = || value.as_f64().filter(|f| f.fract() == 0.0 && (0.0..EXACT).contains(f)).map(|f| f as u64);
    value.as_u64().or_else(float)
}

/// An index in a list of the file.
pub(super) fn index_of(value: &Value) -> Option<usize> {
    usize::try_from(whole(value)?).ok()
}

/// Turns `4.0` into `4` everywhere in a value.
pub(super) fn make_whole(value: &mut Value) {
    match value {
        Value::Number(number) => {
            let float = number.as_f64().filter(|_| number.is_f64());
            if let Some(float) = float.filter(|f| f.fract() == 0.0 && f.abs() < EXACT) {
                *number = (float as i64).into();
            }
        }
        Value::Array(list) => list.iter_mut().for_each(make_whole),
        Value::Object(members) => members.values_mut().for_each(make_whole),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn make_whole_removes_zero_fractions() {
        let mut value: Value = serde_json::from_str(r#"{"a": [4.0, 1e2, -3.0, 0.5, 1e300]}"#).expect("JSON");
        make_whole(&mut value);
        assert_eq!(value.to_string(), r#"{"a":[4,100,-3,0.5,1e+300]}"#);
    }

    #[test]
    fn whole_accepts_only_non_negative_integers() {
        for (value, number) in [
            (json!(4), Some(4)),
            (json!(4.0), Some(4)),
            (json!(u64::MAX), Some(u64::MAX)),
            (json!(0.0), Some(0)),
        ] {
            assert_eq!(whole(&value), number, "{value}");
        }
        for value in [json!(0.5), json!(-1), json!(-1.0), json!(1e300), json!("4"), json!(null), json!([4])] {
            assert_eq!(whole(&value), None, "{value}");
        }
    }
}
