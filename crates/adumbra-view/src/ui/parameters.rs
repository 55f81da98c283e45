//! Parameters of a technique as sliders and lists: what applies, with its default, and back to it.

use adumbra_render::technique::{Parameter, ParameterKind};
use egui::{ComboBox, Slider, SliderClamping, Ui};

/// What the user made of a technique's parameters.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Changed {
    pub(super) key: &'static str,
    pub(super) value: String,
}

/// Shows them; gives the one that was changed.
pub(super) fn show(ui: &mut Ui, salt: &str, parameters: &[Parameter]) -> Option<Changed> {
    let mut changed = None;
    egui::Grid::new(("parameters", salt)).num_columns(3).spacing([6.0, 3.0]).show(ui, |ui| {
        for p in parameters {
            ui.label(p.key).on_hover_text(p.what);
            let value = edit(ui, salt, p);
            let reset = !p.is_default()
                && ui.small_button("⟲").on_hover_text(format!("back to {}", p.default)).clicked();
            if reset {
                changed = Some(Changed { key: p.key, value: p.default.clone() });
            } else if let Some(value) = value {
                changed = Some(Changed { key: p.key, value });
            }
            ui.end_row();
        }
    });
    changed
}

/// One of them; gives its new value where it has one.
fn edit(ui: &mut Ui, salt: &str, p: &Parameter) -> Option<String> {
    match &p.kind {
        ParameterKind::Number { .. } => {
            let (range, by_factors) = p.slider()?;
            let mut value: f64 = p.value.parse().unwrap_or(*range.start());
            let slider =
                Slider::new(&mut value, range).logarithmic(by_factors).clamping(SliderClamping::Edits);
            // A value beyond the slider's ends stays until it is moved.
            ui.add(slider).on_hover_text(p.what).changed().then(|| rounded(value))
        }
        ParameterKind::Count { range } => {
            let mut value: u32 = p.value.parse().unwrap_or(*range.start());
            let slid = ui.add(Slider::new(&mut value, range.clone())).on_hover_text(p.what);
            slid.changed().then(|| value.to_string())
        }
        ParameterKind::Integer { choices } => {
            let words: Vec<String> = choices.iter().map(u32::to_string).collect();
            chosen(ui, salt, p, words.iter().map(String::as_str))
        }
        ParameterKind::Word { choices } => chosen(ui, salt, p, choices.iter().copied()),
        ParameterKind::Technique { .. } => {
            let id = ui.scope_id().with((salt, p.key));
            let mut text = ui.data(|d| d.get_temp(id)).unwrap_or_else(|| p.value.clone());
            let response = ui.text_edit_singleline(&mut text).on_hover_text(p.what);
            // Asked before the data is locked: both are behind one lock.
            let (done, has_focus) = (response.lost_focus() && text != p.value, response.has_focus());
            ui.data_mut(|d| {
                d.remove::<String>(id);
                if has_focus {
                    d.insert_temp(id, text.clone());
                }
            });
            done.then_some(text)
        }
    }
}

fn chosen<'c>(
    ui: &mut Ui,
    salt: &str,
    p: &Parameter,
    choices: impl Iterator<Item = &'c str>,
) -> Option<String> {
    let mut value = p.value.clone();
    ComboBox::from_id_salt((salt, p.key)).selected_text(&value).show_ui(ui, |ui| {
        for choice in choices {
            ui.selectable_value(&mut value, choice.to_owned(), choice);
        }
    });
    (value != p.value).then_some(value)
}

/// Three digits that count are what a slider is worth.
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
    fn slider_gives_three_digits() {
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
