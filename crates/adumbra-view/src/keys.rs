//! The function of each key. The help is generated from the same list.

use crate::command::{Command, Side};
use crate::settings::{Settings, Shown};

/// Keys, as the keyboard names them, and their functions, for the help.
pub(crate) const KEYS: &[(&str, &str)] = &[
    ("t / T", "next, previous technique of the first side"),
    ("y / Y", "next, previous technique of the second side"),
    ("o / O", "next, previous ambient occlusion"),
    ("l / L", "next, previous layer"),
    ("x", "split screen, or the first side alone"),
    (", / .", "move the divider left, right"),
    ("v", "difference of both sides, or the first side alone"),
    ("n", "swap sides"),
    ("w a s d, q e", "fly: ahead, left, back, right, down, up"),
    ("arrows", "orbit"),
    ("+ / -", "zoom in, out"),
    ("[ / ]", "turn the sun left, right"),
    ("{ / }", "lower, raise the sun"),
    ("r", "reset the camera"),
    ("b", "a ball that rolls from sunlight into shadow"),
    ("Space", "run or pause time"),
    ("g", "the bounds of the shadow file as lines"),
    ("m", "one or four samples per pixel"),
    ("c", "save the camera, for compare --camera"),
    ("p", "screenshot without the panel"),
    ("u", "show or hide the panel"),
    ("k", "stop the bake, keep completed levels"),
    ("? / F1", "this help"),
    ("Ctrl+q", "quit"),
];

/// Functions of the mouse, for the help.
pub(crate) const MOUSE: &[(&str, &str)] = &[
    ("left", "orbit; on the divider: move it"),
    ("right", "look around"),
    ("middle, Shift+left", "pan"),
    ("Ctrl+left", "drag the sun"),
    ("wheel", "zoom"),
    ("drop", "open a scene, a shadow file or a camera"),
];

/// File names for screenshots and cameras that are saved by key.
pub(crate) const SCREENSHOT: &str = "adumbra-view.png";
pub(crate) const CAMERA: &str = "adumbra-camera.json";

/// Returns the command of a key under these settings; `None` if the key has no function.
pub(crate) fn command(key: &str, settings: &Settings) -> Option<Command> {
    let divider = |by: f64| match settings.shown {
        Shown::Split(at) => Command::Split((at + by).clamp(0.0, 1.0)),
        _ => Command::Split(0.5),
    };
    let shadow = |side, by| Command::NextShadow { side, by };
    let sun = |azimuth, elevation| Command::TurnSun { azimuth, elevation };
    Some(match key {
        "t" => shadow(Side::First, 1),
        "T" => shadow(Side::First, -1),
        "y" => shadow(Side::Second, 1),
        "Y" => shadow(Side::Second, -1),
        "o" => Command::NextAo(1),
        "O" => Command::NextAo(-1),
        "l" => Command::NextLayer(1),
        "L" => Command::NextLayer(-1),
        "x" if matches!(settings.shown, Shown::Split(_)) => Command::Single,
        "x" => Command::Split(0.5),
        "," => divider(-0.05),
        "." => divider(0.05),
        "v" if matches!(settings.shown, Shown::Difference(_)) => Command::Single,
        "v" => Command::Difference(2.0),
        "n" => Command::ChangeSides,
        "ArrowLeft" => Command::Orbit([-5.0, 0.0]),
        "ArrowRight" => Command::Orbit([5.0, 0.0]),
        "ArrowUp" => Command::Orbit([0.0, 5.0]),
        "ArrowDown" => Command::Orbit([0.0, -5.0]),
        "+" | "=" => Command::Zoom(0.9),
        "-" => Command::Zoom(1.0 / 0.9),
        "[" => sun(-5.0, 0.0),
        "]" => sun(5.0, 0.0),
        "{" => sun(0.0, -5.0),
        "}" => sun(0.0, 5.0),
        "r" => Command::ResetCamera,
        "b" => Command::Ball(!settings.ball),
        "Space" => Command::Play(!settings.playing),
        "g" => Command::Box(!settings.show_box),
        "m" => Command::Antialias(if settings.antialias == 1 { 2 } else { 1 }),
        "c" => Command::SaveCamera(CAMERA.into()),
        "p" | "F12" => Command::Screenshot(SCREENSHOT.into()),
        "u" => Command::Panel(!settings.show_panel),
        "k" => Command::CancelBake,
        "?" | "F1" => Command::Help(!settings.show_help),
        "Escape" if settings.show_help => Command::Help(false),
        "Ctrl+q" => Command::Quit,
        _ => return None,
    })
}

/// Returns the direction in which a held key flies: right, up, ahead.
pub(crate) fn flight(key: &str) -> Option<[f64; 3]> {
    Some(match key {
        "w" => [0.0, 0.0, 1.0],
        "s" => [0.0, 0.0, -1.0],
        "a" => [-1.0, 0.0, 0.0],
        "d" => [1.0, 0.0, 0.0],
        "q" => [0.0, -1.0, 0.0],
        "e" => [0.0, 1.0, 0.0],
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::tests::settings;

    #[test]
    fn every_key_of_the_help_does_something() {
        for (keys, _) in KEYS {
            let keys = match *keys {
                "arrows" => "ArrowLeft ArrowRight ArrowUp ArrowDown".to_owned(),
                "w a s d, q e" => "w a s d q e".to_owned(),
                other => other.replace(" / ", " "),
            };
            for key in keys.split(' ') {
                let does = command(key, &settings()).is_some() || flight(key).is_some();
                assert!(does, "{key}");
            }
        }
    }

    #[test]
    fn pressing_a_toggle_key_twice_restores_the_settings() {
        let mut s = settings();
        for key in ["x", "v", "b", "Space", "g", "m", "u", "?"] {
            let before = s.clone();
            for _ in 0..2 {
                let command = command(key, &s).unwrap();
                s.apply(&command).unwrap();
            }
            assert_eq!(s, before, "{key}");
        }
        assert_eq!(command("x", &s), Some(Command::Split(0.5)));
        assert_eq!(command("F5", &s), None);
    }
}
