//! Help for the parameters of ambient occlusion, generated from the keys that parsing requests.

use super::describe;
use super::estimator::Estimator;
use super::settings::DEFAULT_RADIUS_SHARE;
use crate::technique::Parameter;

/// All names of ambient occlusion, each with a description.
pub const OCCLUSIONS: [(&str, &str); 7] = [
    ("ssao", "points in a hemisphere that are behind the visible surface (Mittring 2007)"),
    ("hbao", "horizons along a few directions (Bavoil, Sainz, Dimitrov 2008)"),
    ("alchemy", "occluders above the tangent plane, weighted by distance (McGuire et al. 2011)"),
    ("issao", "like alchemy, with an attenuation and denser samples near the point (Qiu et al. 2014)"),
    ("gtao", "horizons of slices, with their arcs integrated (Jimenez et al. 2016)"),
    ("truth", "rays on the CPU"),
    ("none", "open sky everywhere"),
];

/// Parameters specific to an estimator, one per entry: `key=default (range or words): description`. For
/// `truth`, all of its parameters. Empty for any other name.
pub fn occlusion_parameters(name: &str) -> Vec<String> {
    let common = common();
    lines(described(name).iter().filter(|p| name == "truth" || !common.contains(&p.key)))
}

/// Parameters common to all estimators, in the format of [`occlusion_parameters`].
pub fn occlusion_options() -> Vec<String> {
    let common = common();
    lines(described(Estimator::ALL[0].name()).iter().filter(|p| common.contains(&p.key)))
}

/// Keys that every estimator requests.
fn common() -> Vec<&'static str> {
    let of = |e: &Estimator| -> Vec<&str> { described(e.name()).iter().map(|p| p.key).collect() };
    let [first, others @ ..] = &Estimator::ALL;
    let others: Vec<Vec<&str>> = others.iter().map(of).collect();
    of(first).into_iter().filter(|key| others.iter().all(|o| o.contains(key))).collect()
}

fn described(name: &str) -> Vec<Parameter> {
    name.parse().and_then(|spec| describe(&spec, 0.0)).unwrap_or_default()
}

fn lines<'p>(parameters: impl Iterator<Item = &'p Parameter>) -> Vec<String> {
    let line = |p: &Parameter| match p.key {
        "radius" => {
            format!(
                "radius= (world units, {} % of the scene's usual diagonal): {}",
                100.0 * DEFAULT_RADIUS_SHARE,
                p.what
            )
        }
        _ => format!("{}: {}", p.help(), p.what),
    };
    parameters.map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn help_names_every_occlusion() {
        let named: Vec<&str> = OCCLUSIONS.iter().map(|(name, _)| *name).collect();
        let estimators = Estimator::ALL.map(Estimator::name);
        assert_eq!(named, [&estimators[..], &["truth", "none"]].concat());
    }

    #[test]
    fn help_lists_each_occlusion_parameter_once() {
        for (name, _) in OCCLUSIONS {
            let options = if matches!(name, "truth" | "none") { Vec::new() } else { occlusion_options() };
            let listed = [options, occlusion_parameters(name)].concat();
            let mut named: Vec<&str> = listed.iter().map(|l| l.split_once('=').unwrap().0).collect();
            let mut asked: Vec<&str> = described(name).iter().map(|p| p.key).collect();
            named.sort_unstable();
            asked.sort_unstable();
            assert_eq!(named, asked, "{name}");
        }
        assert!(occlusion_parameters("unknown").is_empty());
        assert!(
            occlusion_parameters("issao").iter().any(|l| l.starts_with("preset=none, fig3, fig4 or fig5: "))
        );
        assert!(occlusion_options().iter().any(|l| l == "samples=12 (1 to 64): taps per pixel"));
    }
}
