//! Parameters of a technique as sliders and lists, with their current values, defaults and a reset button.

use adumbra_render::technique::{Parameter, ParameterKind};
use adumbra_render::{RenderError, SpecText, TECHNIQUES};
use egui::{ComboBox, Slider, SliderClamping, Ui};

/// A change of one of a technique's parameters: a new value, or `None` to reset it to the default.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Changed {
    pub(super) key: &'static str,
    pub(super) value: Option<String>,
}

impl Changed {
    /// Returns the technique with this change. `change` writes it as briefly as possible. If `change` fails,
    /// the value is written out in full, and is rejected when it is used.
    pub(super) fn of(
        &self,
        spec: &SpecText,
        change: impl FnOnce(&str, &str) -> Result<SpecText, RenderError>,
    ) -> SpecText {
        let plain = spec.with(self.key, self.value.as_deref());
        self.value.as_deref().and_then(|value| change(self.key, value).ok()).unwrap_or(plain)
    }
}

/// Initial value of a slider without a default.
const USUAL: f64 = 100.0;

/// Shows the parameters and returns the one that was changed. `describe` returns the parameters of a nested
/// technique.
pub(super) fn show(
    ui: &mut Ui,
    salt: &str,
    parameters: &[Parameter],
    describe: &dyn Fn(&SpecText) -> Vec<Parameter>,
) -> Option<Changed> {
    let mut changed = None;
    egui::Grid::new(("parameters", salt)).num_columns(3).spacing([6.0, 3.0]).show(ui, |ui| {
        for p in parameters {
            ui.label(p.key).on_hover_text(p.what);
            let value = edit(ui, salt, p, describe);
            let default = if p.default.is_empty() { "automatic" } else { &p.default };
            let reset = !p.is_default()
                && ui.small_button("reset").on_hover_text(format!("back to {default}")).clicked();
            if reset {
                changed = Some(Changed { key: p.key, value: None });
            } else if value.is_some() {
                changed = Some(Changed { key: p.key, value });
            }
            ui.end_row();
        }
    });
    changed
}

/// Shows one parameter and returns its new value, if it has one.
fn edit(
    ui: &mut Ui,
    salt: &str,
    p: &Parameter,
    describe: &dyn Fn(&SpecText) -> Vec<Parameter>,
) -> Option<String> {
    match &p.kind {
        ParameterKind::Number { range } if p.value.is_empty() => {
            let usual = USUAL.clamp(*range.start(), *range.end());
            ui.small_button("automatic").on_hover_text(p.what).clicked().then(|| rounded(usual))
        }
        ParameterKind::Number { .. } => {
            let (range, by_factors) = p.slider()?;
            let mut value: f64 = p.value.parse().unwrap_or(*range.start());
            let slider =
                Slider::new(&mut value, range).logarithmic(by_factors).clamping(SliderClamping::Edits);
            // A value outside the slider's range stays unchanged until the slider is moved.
            ui.add(slider).on_hover_text(p.what).changed().then(|| rounded(value))
        }
        ParameterKind::Count { range } => {
            let mut value: u32 = p.value.parse().unwrap_or(*range.start());
            let slid = ui.add(Slider::new(&mut value, range.clone())).on_hover_text(p.what);
            slid.changed().then(|| value.to_string())
        }
        ParameterKind::Integer { choices } => {
            let words: Vec<String> = choices.iter().map(u32::to_string).collect();
            chosen(ui, (salt, p.key), &p.value, words.iter().map(String::as_str))
        }
        ParameterKind::Word { choices } => chosen(ui, (salt, p.key), &p.value, choices.iter().copied()),
        ParameterKind::Technique { of } => {
            let spec = p.nested().ok().flatten()?;
            let inner =
                ui.vertical(|ui| nested(ui, &format!("{salt}/{}", p.key), &spec, of.is_none(), describe));
            inner.inner.map(|spec| p.nest(&spec))
        }
    }
}

/// Shows a nested technique: its name, if that can be changed, and its parameters.
fn nested(
    ui: &mut Ui,
    salt: &str,
    spec: &SpecText,
    has_name: bool,
    describe: &dyn Fn(&SpecText) -> Vec<Parameter>,
) -> Option<SpecText> {
    let other = if has_name {
        let names = TECHNIQUES.iter().filter(|t| t.can_be_blurred()).map(|t| t.name);
        chosen(ui, (salt, "name"), spec.name(), names)
    } else {
        None
    };
    let parameters = describe(spec);
    let title = format!("{} parameters of {}", parameters.len(), spec.name());
    let changed = egui::CollapsingHeader::new(title)
        .id_salt((salt, "parameters"))
        .show(ui, |ui| show(ui, salt, &parameters, describe))
        .body_returned
        .flatten();
    match (other, changed) {
        (Some(name), _) => name.parse().ok(),
        (None, Some(Changed { key, value })) => Some(spec.with(key, value.as_deref())),
        (None, None) => None,
    }
}

fn chosen<'c>(
    ui: &mut Ui,
    salt: impl std::hash::Hash + std::fmt::Debug,
    now: &str,
    choices: impl Iterator<Item = &'c str>,
) -> Option<String> {
    let mut value = now.to_owned();
    ComboBox::from_id_salt(salt).selected_text(&value).show_ui(ui, |ui| {
        for choice in choices {
            ui.selectable_value(&mut value, choice.to_owned(), choice);
        }
    });
    (value != now).then_some(value)
}

/// Formats a slider's value with three significant digits.
fn rounded(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = (2.0 - value.abs().log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

#[cfg(test)]
mod tests {
    use super::rounded;

    #[test]
    fn slider_value_has_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (0.5, "0.5"),
            (1.0 / 3.0, "0.333"),
            (12.345, "12.3"),
            (1234.5, "1234"),
            (0.00123456, "0.00123"),
        ] {
            assert_eq!(rounded(value), text);
        }
    }
}
