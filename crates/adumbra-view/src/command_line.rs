//! The command line that reproduces a view.

use std::path::Path;

use adumbra_scene::Projection;

use crate::day::DayOptions;
use crate::navigation;
use crate::settings::{Settings, Shown};

/// Quotes a word for a POSIX shell.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:=,+".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', "'\\''"))
    }
}

/// Returns `adumbra view …` with all settings; `ball` is the text with which the ball was requested.
pub(crate) fn of(
    scene: &Path,
    shadow_file: Option<&Path>,
    day: Option<(Option<&DayOptions>, f64)>,
    ball: Option<&str>,
    settings: &Settings,
) -> String {
    let s = settings;
    let point = |p: [f64; 3]| format!("{},{},{}", p[0], p[1], p[2]);
    let mut words = vec!["adumbra".to_owned(), "view".to_owned(), quoted(&scene.display().to_string())];
    let mut add = |name: &str, value: String| words.extend([format!("--{name}"), quoted(&value)]);
    if let Some(path) = shadow_file {
        add("shadow-file", path.display().to_string());
    }
    if let Some((options, hour)) = day {
        if let Some(text) = options.and_then(|day| day.text.as_ref()) {
            add("day", text.clone());
        }
        if let Some(day) = options {
            add("day-length", day.length_seconds.to_string());
            if let Some(near) = day.near_world {
                add("day-near", near.to_string());
            }
        }
        add("hour", hour.to_string());
    } else if shadow_file.is_none() {
        let [azimuth, elevation] = navigation::angles(s.sun.towards());
        add("azimuth", azimuth.to_string());
        add("elevation", elevation.to_string());
    }
    for shadow in &s.shadows {
        add("shadow", shadow.to_string());
    }
    add("ao", s.ambient.to_string());
    add("layer", s.layer.name().to_owned());
    match s.shown {
        Shown::Single => {}
        Shown::Split(at) => add("split", at.to_string()),
        Shown::Difference(gain) => add("difference", gain.to_string()),
    }
    add("eye", point(s.camera.eye));
    add("target", point(s.camera.target));
    match s.camera.projection {
        Projection::Perspective { fov_degrees } => add("fov", fov_degrees.to_string()),
        Projection::Orthographic { height_world } => add("ortho", height_world.to_string()),
    }
    add("size", format!("{}x{}", s.camera.width, s.camera.height));
    add("antialias", s.antialias.to_string());
    add("resolution", s.resolution.to_string());
    add("budget", s.budget_mib.to_string());
    add("fade", s.fade_frames.to_string());
    if s.ball {
        add("move", ball.unwrap_or("sphere").to_owned());
    }
    add("time", s.seconds.to_string());
    let switches = [
        (s.playing, "--play"),
        (s.show_box, "--box"),
        (!s.show_panel, "--no-panel"),
        (s.continuous, "--continuous"),
    ];
    for (on, name) in switches {
        if on {
            words.push(name.to_owned());
        }
    }
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::tests::settings;

    #[test]
    fn command_line_includes_every_setting() {
        let mut s = settings();
        s.shown = Shown::Split(0.25);
        s.ball = true;
        let line = of(Path::new("my city.glb"), None, None, Some("sphere:radius=2"), &s);
        assert!(line.starts_with("adumbra view 'my city.glb' --azimuth "), "{line}");
        for part in [
            "--shadow voxel --shadow csm:cascades=3",
            "--split 0.25",
            "--eye 0,5,10",
            "--size 320x200",
            "--move sphere:radius=2",
        ] {
            assert!(line.contains(part), "{line}");
        }
        let line = of(Path::new("a.glb"), Some(Path::new("it's.adumbra")), None, None, &s);
        assert!(line.contains(r"--shadow-file 'it'\''s.adumbra'") && !line.contains("azimuth"), "{line}");
    }
}
