//! Points from a table.

use super::{Facing, Receiver, some};
use crate::error::{Error, Result};
use adumbra::grid::vec3::{dot, normalize};

/// Reads points from text: on each line x, y, z in world units, and a normal of any length if the point is on
/// a surface, separated by commas, semicolons, tabs or spaces. A first line of names, empty lines and text
/// after `#` are skipped. Rays start `lift_world` above points with a normal, and at the points themselves
/// otherwise.
///
/// # Errors
/// Returns [`Error::Line`] for the first line that cannot be read, [`Error::NoPoints`] if there is no point,
/// and [`Error::Range`] if the lift is negative or not finite.
pub fn read_csv(text: &str, lift_world: f64) -> Result<Vec<Receiver>> {
    if !(lift_world >= 0.0 && lift_world.is_finite()) {
        return Err(Error::Range { field: "lift", value: lift_world, expected: "0 or more world units" });
    }
    let mut points = Vec::new();
    let mut names = true;
    for (index, line) in text.lines().enumerate() {
        let wrong = |what: String| Error::Line { line: index + 1, what };
        let content = line.split('#').next().unwrap_or_default().trim_matches([' ', '\t', '\r']);
        if content.is_empty() {
            continue;
        }
        let is_first = std::mem::replace(&mut names, false);
        let words = content.split([',', ';', '\t', ' ']).map(str::trim).filter(|word| !word.is_empty());
        let words: Vec<&str> = words.collect();
        if is_first && words.iter().all(|word| word.parse::<f64>().is_err()) {
            continue;
        }
        let number = |word: &&str| {
            let number = word.parse::<f64>().ok().filter(|n| n.is_finite());
            number.ok_or_else(|| wrong(format!("{word:?} is not a finite number")))
        };
        let numbers = words.iter().map(number).collect::<Result<Vec<f64>>>()?;
        let (p_world, facing) = match numbers[..] {
            [x, y, z] => ([x, y, z], Facing::Space),
            [x, y, z, nx, ny, nz] => {
                let normal = [nx, ny, nz];
                if !(dot(normal, normal) > 0.0) {
                    return Err(wrong("the normal has no length".to_owned()));
                }
                ([x, y, z], Facing::Front(normalize(normal)))
            }
            _ => return Err(wrong(format!("{} numbers, but there should be 3 or 6", numbers.len()))),
        };
        points.push(Receiver { p_world, facing, lift_world });
    }
    some(points, "in the table", "give x,y,z or x,y,z,nx,ny,nz on each line")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_table_with_and_without_normals() {
        let text = "x,y,z,nx,ny,nz # names\n1,2,3\r\n\n 4; 5;\t6;0;0;-2 # a wall\n-1e3 0 0";
        let points = read_csv(text, 0.25).unwrap();
        let of = |p_world, facing| Receiver { p_world, facing, lift_world: 0.25 };
        assert_eq!(
            points,
            [
                of([1.0, 2.0, 3.0], Facing::Space),
                of([4.0, 5.0, 6.0], Facing::Front([0.0, 0.0, -1.0])),
                of([-1000.0, 0.0, 0.0], Facing::Space),
            ]
        );
    }

    #[test]
    fn rejects_invalid_table_with_line_number() {
        for (text, message) in [
            ("1,2,3\n1,2", "line 2: 2 numbers"),
            ("1,2,x", "line 1: \"x\""),
            ("x,y,z\nx,y,z", "line 2: \"x\""),
            ("1,2,inf", "line 1: \"inf\""),
            ("1,2,3,0,0,0", "line 1: the normal"),
            ("x,y,z\n", "no point in the table"),
        ] {
            let error = read_csv(text, 0.0).unwrap_err().to_string();
            assert!(error.contains(message), "{text}: {error}");
        }
        assert!(matches!(read_csv("1,2,3", -1.0), Err(Error::Range { field: "lift", .. })));
    }
}
