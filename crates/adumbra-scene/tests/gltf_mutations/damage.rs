//! Damage to glTF files: to the values of the JSON, to its text, to the container and to the data.

use adumbra_testing::glb as container;
use serde_json::{Value, json};

use crate::dice::Dice;
use crate::each_value;
use crate::kit::Glb;

/// Returns the bytes of a file with one to three faults.
pub(crate) fn damaged(dice: &mut Dice, glb: &Glb) -> Vec<u8> {
    let (mut json, mut bin) = (glb.json.clone(), glb.bin.clone());
    let mut in_container = 0;
    for _ in 0..=dice.below(3) {
        match dice.below(10) {
            0 => change_bytes(dice, &mut bin),
            1 => in_container += 1,
            _ => change_value(dice, &mut json),
        }
    }
    let mut bytes = container(&json, &bin);
    for _ in 0..in_container {
        change_container(dice, &mut bytes);
    }
    bytes
}

/// Replaces, removes, cuts or repeats a value anywhere in the JSON.
fn change_value(dice: &mut Dice, json: &mut Value) {
    let mut count = 0;
    each_value(json, &mut |_| count += 1);
    let (chosen, mut at) = (dice.below(count), 0);
    let fault = dice.below(8);
    let other = replacement(dice);
    let (place, place_to) = (dice.below(1 << 16), dice.below(1 << 16));
    each_value(json, &mut |value| {
        at += 1;
        if at - 1 != chosen {
            return;
        }
        match (value, fault) {
            (Value::Array(list), 0 | 1) if !list.is_empty() => list.truncate(place % list.len()),
            (Value::Array(list), 2 | 3) if !list.is_empty() => {
                let copy = list[place % list.len()].clone();
                list.insert(place_to % (list.len() + 1), copy);
            }
            (Value::Array(list), 4) if !list.is_empty() => {
                let (a, b) = (place % list.len(), place_to % list.len());
                list.swap(a, b);
            }
            (Value::Object(members), 0..=3) if !members.is_empty() => {
                let key = members.keys().nth(place % members.len()).cloned().unwrap_or_default();
                members.remove(&key);
            }
            (Value::Object(members), 4) if !members.is_empty() => {
                let key = members.keys().nth(place % members.len()).cloned().unwrap_or_default();
                members.insert(key, other.clone());
            }
            // Replacing the whole file by another value is of little interest.
            (Value::Object(members), _) if members.contains_key("asset") => {
                members.remove("asset");
            }
            (Value::Number(number), 0 | 1) => {
                let near = number.as_f64().unwrap_or_default() + f64::from(place as u32 % 5) - 2.0;
                *number = (near as i64).into();
            }
            (value, _) => *value = other.clone(),
        }
    });
}

/// A value of any type.
fn replacement(dice: &mut Dice) -> Value {
    let texts =
        ["", "a", "POSITION", "MASK", "VEC3", "MAT4", "../a", "a%2", "data:;base64,AAA", "\u{0}\n", "9"];
    let word = dice.pick(&texts);
    let numbers = [0, 1, 2, 3, 5, 7, 255, 5120, 5121, 5125, 5126, 65_536, 0xffff_ffff];
    let number: u64 = dice.pick(&numbers);
    dice.pick(&[
        json!(null),
        json!(true),
        json!(number),
        json!(number),
        json!(number as f64),
        json!(number as f64 + 0.5),
        json!(-1),
        json!(-0.0),
        json!(u64::MAX),
        json!(1_u64 << 40),
        json!(1e300),
        json!(-1e39),
        json!(word),
        json!([]),
        json!([number, 1]),
        json!({}),
        json!({"index": number, "nodes": [number], "name": word}),
    ])
}

fn change_bytes(dice: &mut Dice, bin: &mut Vec<u8>) {
    if bin.is_empty() {
        return;
    }
    let at = dice.below(bin.len());
    match dice.below(4) {
        0 => bin.truncate(at),
        1 => bin[at] ^= 1 << dice.below(8),
        _ => {
            let (length, byte) = (1 + dice.below(16), dice.pick(&[0, 0x7f, 0x80, 0xff]));
            bin.iter_mut().skip(at).take(length).for_each(|b| *b = byte);
        }
    }
}

/// Changes the header, a chunk's length or kind, the text, or the file's length.
fn change_container(dice: &mut Dice, bytes: &mut Vec<u8>) {
    let json =
        u32::from_le_bytes([12, 13, 14, 15].map(|i| bytes.get(i).copied().unwrap_or_default())) as usize;
    let at = match dice.below(4) {
        0 => dice.below(20),
        1 => 20 + json + dice.below(8),
        _ => dice.below(bytes.len().max(1)),
    };
    match dice.below(6) {
        0 => bytes.truncate(at),
        1 => bytes.splice(at.min(bytes.len())..at.min(bytes.len()), *b"\x04\0\0\0METAabcd").for_each(drop),
        2 => bytes.iter_mut().skip(at).take(4).for_each(|b| *b = 0xff),
        _ => {
            let flip = 1 << dice.below(8);
            bytes.iter_mut().skip(at).take(1).for_each(|b| *b ^= flip);
        }
    }
}
