//! Keys and the mouse, unless the panel uses them.

use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::{Key, NamedKey};

use super::Open;
use crate::command::Command;
use crate::settings::Shown;
use crate::{keys, ui};

/// Degrees of rotation for a drag over the whole height.
const DRAG_DEGREES: f64 = 180.0;

#[derive(Default)]
pub(super) struct Pointer {
    pub(super) at: [f64; 2],
    pub(super) drag: Option<Drag>,
}

#[derive(Clone, Copy)]
pub(super) enum Drag {
    Orbit,
    Look,
    Pan,
    Sun,
    Divider,
}

impl Open {
    /// Handles a key that the panel does not use.
    fn key(&mut self, key: &Key, pressed: bool, repeats: bool) {
        let name = match key {
            Key::Character(text) => text.to_string(),
            Key::Named(NamedKey::Space) => "Space".to_owned(),
            Key::Named(named) => format!("{named:?}"),
            _ => return,
        };
        if !pressed {
            self.held.remove(&name.to_lowercase());
            return;
        }
        // On some systems AltGr is reported as Control with Alt, and is already part of the key's name.
        let has_control = self.modifiers.control_key() && !self.modifiers.alt_key();
        let name = if has_control { format!("Ctrl+{}", name.to_lowercase()) } else { name };
        if keys::flight(&name.to_lowercase()).is_some() {
            // Flies at least once, however briefly the key is pressed.
            if self.held.insert(name.to_lowercase()) {
                self.app.command(&Command::Key(name.to_lowercase()));
            }
            return;
        }
        let Some(command) = keys::command(&name, &self.app.settings) else { return };
        let goes_on = matches!(
            command,
            Command::Orbit(_) | Command::Zoom(_) | Command::TurnSun { .. } | Command::Split(_)
        );
        if goes_on || !repeats {
            self.app.command(&Command::Key(name));
        }
    }

    /// Returns the direction in which the held keys fly: right, up, ahead.
    pub(super) fn flight(&self) -> [f64; 3] {
        let ways = self.held.iter().filter_map(|key| keys::flight(key));
        ways.fold([0.0; 3], |sum, way| std::array::from_fn(|a| sum[a] + way[a]))
    }

    fn is_on_divider(&self) -> bool {
        let Shown::Split(at) = self.app.settings.shown else { return false };
        let grip = f64::from(ui::GRIP_POINTS) * self.window.scale_factor();
        (self.pointer.at[0] - at * f64::from(self.config.width)).abs() <= grip
    }

    fn button(&mut self, button: MouseButton, state: ElementState) {
        if state == ElementState::Released {
            self.pointer.drag = None;
            return;
        }
        let m = self.modifiers;
        self.pointer.drag = match button {
            MouseButton::Left if self.is_on_divider() => Some(Drag::Divider),
            MouseButton::Left if m.control_key() || m.alt_key() => Some(Drag::Sun),
            MouseButton::Left if m.shift_key() => Some(Drag::Pan),
            MouseButton::Left => Some(Drag::Orbit),
            MouseButton::Right => Some(Drag::Look),
            MouseButton::Middle => Some(Drag::Pan),
            _ => None,
        };
    }

    fn moved(&mut self, to: [f64; 2]) {
        let height = f64::from(self.config.height);
        let [dx, dy] = [to[0] - self.pointer.at[0], to[1] - self.pointer.at[1]].map(|d| d / height);
        self.pointer.at = to;
        let [right, down] = [dx * DRAG_DEGREES, dy * DRAG_DEGREES];
        let command = match self.pointer.drag {
            None => return,
            Some(Drag::Orbit) => Command::Orbit([-right, down]),
            Some(Drag::Look) => Command::Look([right, -down]),
            Some(Drag::Pan) => Command::Pan([-dx, dy]),
            Some(Drag::Sun) => Command::TurnSun { azimuth: right, elevation: -down },
            Some(Drag::Divider) => Command::Split((to[0] / f64::from(self.config.width)).clamp(0.0, 1.0)),
        };
        self.app.command(&command);
    }

    /// Handles an event; `taken` is whether the panel used it.
    pub(super) fn event(&mut self, event: &WindowEvent, taken: bool) {
        match event {
            WindowEvent::Resized(size) => self.resized(*size),
            WindowEvent::ScaleFactorChanged { .. } => self.resized(self.window.inner_size()),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::DroppedFile(path) => self.app.command(&Command::Drop(path.clone())),
            WindowEvent::Focused(false) => self.held.clear(),
            WindowEvent::KeyboardInput { event, is_synthetic, .. } => {
                let pressed = event.state == ElementState::Pressed;
                if !pressed || !taken && !is_synthetic {
                    self.key(&event.logical_key, pressed, event.repeat);
                }
            }
            WindowEvent::CursorMoved { position, .. } => self.moved([position.x, position.y]),
            WindowEvent::MouseInput { state, button, .. } if !taken || *state == ElementState::Released => {
                self.button(*button, *state);
            }
            WindowEvent::MouseWheel { delta, .. } if !taken => {
                let lines = match delta {
                    MouseScrollDelta::LineDelta(_, y) => f64::from(*y),
                    MouseScrollDelta::PixelDelta(p) => p.y / 50.0,
                };
                self.app.command(&Command::Zoom(0.9_f64.powf(lines.clamp(-20.0, 20.0))));
            }
            _ => {}
        }
    }
}
