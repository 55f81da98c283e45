//! Parsers of values on the command line.

use adumbra::Bounds;

/// Parses `N` numbers separated by commas.
///
/// # Errors
///
/// Returns a message that says what to give if the text is anything else.
pub fn numbers<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let parts: Vec<f64> = text
        .split(',')
        .map(|p| p.trim().parse::<f64>().map_err(|_| format!("{p:?} is not a number")))
        .collect::<Result<_, _>>()?;
    <[f64; N]>::try_from(parts).map_err(|p| format!("give {N} numbers separated by commas, not {}", p.len()))
}

/// Parses a point or a direction, as `X,Y,Z`.
///
/// # Errors
///
/// Returns a message that says what to give if the text is anything else.
pub fn parse_triple(text: &str) -> Result<[f64; 3], String> {
    numbers::<3>(text)
}

/// Parses a box, as `X0,Y0,Z0,X1,Y1,Z1`.
///
/// # Errors
///
/// Returns a message that says what to give if the text is anything else.
pub fn parse_bounds(text: &str) -> Result<Bounds, String> {
    let [x0, y0, z0, x1, y1, z1] = numbers::<6>(text)?;
    Ok(Bounds { min: [x0, y0, z0], max: [x1, y1, z1] })
}

/// Parses a size in pixels, such as `1280x720`.
///
/// # Errors
///
/// Returns a message that says what to give if the text is anything else, or if a side is not from 1
/// to 16384.
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let (w, h) = text.split_once(['x', 'X']).ok_or("give WIDTHxHEIGHT, such as 1280x720")?;
    let side = |s: &str| match s.parse::<u32>() {
        Ok(n) if (1..=16384).contains(&n) => Ok(n),
        _ => Err(format!("{s:?} is not a number of pixels from 1 to 16384")),
    };
    Ok([side(w)?, side(h)?])
}

/// Parses a number of bytes, such as `800MiB` or `2GiB`.
///
/// # Errors
///
/// Returns a message that says what to give if the text is anything else.
pub fn parse_bytes(text: &str) -> Result<u64, String> {
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let number: f64 = number.parse().map_err(|_| "give a number and a unit, such as 2GiB".to_owned())?;
    let scale = match unit.trim().to_ascii_lowercase().as_str() {
        "" | "b" => 1.0,
        "k" | "kib" => 1024.0,
        "kb" => 1e3,
        "m" | "mib" => 1024.0 * 1024.0,
        "mb" => 1e6,
        "g" | "gib" => 1024.0 * 1024.0 * 1024.0,
        "gb" => 1e9,
        other => return Err(format!("{other:?} is not a unit; use MiB or GiB")),
    };
    Ok((number * scale) as u64)
}
