//! The parameters of techniques as help text, generated from what the readers of settings record.

use std::collections::BTreeMap;

use super::baked::TechniqueFiles;
use super::list::Techniques;
use crate::technique::{Parameter, ParameterKind};

impl Techniques {
    /// Returns the parameters of a technique as shown in help: `key=default` and the other accepted values.
    /// Parameters that always apply come first, then those that apply only with a certain word as another
    /// parameter's value. Empty if the technique has no parameters or does not exist.
    pub fn parameters(self, name: &str) -> String {
        let text = |(p, goes_with): &(Parameter, Option<String>)| match goes_with {
            None => p.help(),
            Some(word) => format!("{} with {word}", p.help()),
        };
        self.all(name).iter().map(text).collect::<Vec<_>>().join("; ")
    }

    /// Returns a description of every parameter, sorted by key, as `key: description`. A key that means
    /// different things in different techniques has several entries.
    pub fn parameter_texts(self) -> Vec<String> {
        let mut texts: BTreeMap<&str, BTreeMap<&str, Vec<&str>>> = BTreeMap::new();
        for technique in self.iter() {
            for (p, _) in self.all(technique.name) {
                texts.entry(p.key).or_default().entry(p.what).or_default().push(technique.name);
            }
        }
        let of_key = |(key, whats): (&&str, &BTreeMap<&str, Vec<&str>>)| -> Vec<String> {
            let users = |users: &[&str]| {
                if whats.len() > 1 { format!(" ({})", users.join(", ")) } else { String::new() }
            };
            whats.iter().map(|(what, names)| format!("{key}: {what}{}", users(names))).collect()
        };
        texts.iter().flat_map(of_key).collect()
    }

    /// Returns a technique's parameters. Those that do not always apply come with the `key=word` that they
    /// require.
    fn all(self, name: &str) -> Vec<(Parameter, Option<String>)> {
        let Ok(plain) = self.parse(name) else { return Vec::new() };
        let mut found: Vec<(Parameter, Option<String>)> = plain
            .describe(TechniqueFiles::default())
            .unwrap_or_default()
            .into_iter()
            .map(|p| (p, None))
            .collect();
        for i in 0..found.len() {
            let ParameterKind::Word { choices } = found[i].0.kind.clone() else { continue };
            let key = found[i].0.key;
            let with = |choice: &str| plain.with(key, Some(choice))?.describe(TechniqueFiles::default());
            let words: Vec<Vec<Parameter>> = choices.iter().map(|c| with(c).unwrap_or_default()).collect();
            for (word, with_word) in choices.iter().zip(&words) {
                for p in with_word.iter().filter(|p| words.iter().any(|w| w.iter().all(|q| q.key != p.key))) {
                    let condition = Some(format!("{key}={word}"));
                    match found.iter_mut().find(|(q, _)| q.key == p.key) {
                        Some((_, goes_with)) if goes_with.is_none() => *goes_with = condition,
                        Some(_) => {}
                        None => found.push((p.clone(), condition)),
                    }
                }
            }
        }
        // Parameters that always apply come first.
        found.sort_by_key(|(_, goes_with)| goes_with.is_some());
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::techniques::TECHNIQUES;

    #[test]
    fn help_names_every_parameter_of_every_technique() {
        for name in TECHNIQUES.iter().map(|t| t.name) {
            let (list, help) = (Techniques::product(), Techniques::product().parameters(name));
            for p in list.parse(name).unwrap().describe(TechniqueFiles::default()).unwrap() {
                assert!(help.split("; ").any(|h| h.starts_with(&p.help())), "{name}: {}: {help}", p.key);
                let text = format!("{}: {}", p.key, p.what);
                assert!(list.parameter_texts().iter().any(|t| t.starts_with(&text)), "{name}: {text}");
            }
        }
        assert!(["none", "unknown"].iter().all(|name| Techniques::product().parameters(name).is_empty()));
    }

    #[test]
    fn help_says_when_a_parameter_applies() {
        let parameters = |name: &str| Techniques::product().parameters(name);
        let lists = |name: &str, part: &str| assert!(parameters(name).contains(part), "{}", parameters(name));
        lists("csm", "cascades=4 (1 to 8); ");
        lists("csm", "; radius=2 (0.5 to 32) with filter=poisson");
        lists("csm", "; lambda=0.5 (0 to 1) with split=practical");
        lists("voxel", "; sun-degrees=0.53 (0.01 to 20) with shade=soft");
        lists("voxel", "; filter=5, 1, 3, 9 or 17 with shade=hard");
        lists("hrsm", "tolerance=0.5 (0 to 64) with test=plane");
        lists("hrsm", "sizes=4096-1024 (one of 256-128, 256-64 .. 8192-1024)");
        lists("blur", "base=pcf/filter=2 (a technique, / for :)");
        lists("voxel+csm", "csm= (parameters of csm, / for :)");
        lists("sm", "size=2048 (one of 128, 256 .. 16384)");
    }
}
