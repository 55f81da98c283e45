//! The estimators of ambient occlusion and their parameters.

use std::fmt;

/// An algorithm that estimates occlusion from depth and normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Estimator {
    /// Points in a hemisphere that lie behind the visible surface: Mittring, *Finding Next Gen: CryEngine
    /// 2*, 2007.
    Ssao,
    /// Horizons along a few directions: Bavoil, Sainz, Dimitrov, *Image-Space Horizon-Based Ambient
    /// Occlusion*, 2008.
    Hbao,
    /// McGuire, Osman, Bukowski, Hennessy, *The Alchemy Screen-Space Ambient Obscurance Algorithm*, 2011.
    Alchemy,
    /// Qiu, Li, Wu, Shi, Zhang, *Improved Screen Space Ambient Occlusion*, 2014.
    Issao,
    /// Jimenez, Wu, Pesce, Jarabo, *Practical Real-Time Strategies for Accurate Indirect Occlusion*, 2016.
    Gtao,
}

/// A numeric parameter of an estimator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeParameter {
    /// Name in a technique's text.
    pub name: &'static str,
    /// Help text, with the unit.
    pub what: &'static str,
    /// Default value. For parameters with a search range, the result of `adumbra-lab tune-ao` over all of its
    /// scenes.
    pub default: f64,
    /// Smallest and largest value.
    pub range: [f64; 2],
    /// Range in which the tuner searches. `None` for a parameter that it does not change.
    pub search: Option<Search>,
    /// Words for the values 0, 1 and so on. Empty for a number.
    pub words: &'static [&'static str],
}

/// Search range of a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Search {
    /// Linear between the two values.
    Even(f64, f64),
    /// Logarithmic between the two values.
    Factors(f64, f64),
}

/// Largest number of parameters of an estimator.
pub const MAX_PARAMETERS: usize = 9;

use Search::{Even, Factors};

const fn tuned(
    name: &'static str,
    what: &'static str,
    default: f64,
    range: [f64; 2],
    search: Search,
) -> ShapeParameter {
    ShapeParameter { name, what, default, range, search: Some(search), words: &[] }
}

const fn fixed(name: &'static str, what: &'static str, default: f64, range: [f64; 2]) -> ShapeParameter {
    ShapeParameter { name, what, default, range, search: None, words: &[] }
}

const fn word(
    name: &'static str,
    what: &'static str,
    words: &'static [&'static str],
    default: u8,
) -> ShapeParameter {
    let range = [0.0, words.len() as f64 - 1.0];
    ShapeParameter { name, what, default: default as f64, range, search: None, words }
}

const SSAO: &[ShapeParameter] = &[
    tuned("strength", "factor of the occlusion", 0.667, [0.0, 10.0], Factors(0.3, 3.0)),
    tuned("power", "exponent of the visibility", 3.81, [0.1, 20.0], Factors(0.5, 12.0)),
    tuned(
        "bias",
        "minimum distance of an occluder in front of the point, radii",
        0.0388,
        [0.0, 1.0],
        Factors(0.005, 0.3),
    ),
    tuned(
        "range",
        "depth difference up to which an occluder counts fully, radii",
        0.521,
        [0.01, 100.0],
        Factors(0.2, 5.0),
    ),
    fixed(
        "tangent",
        "1: occluders must also rise above the tangent plane by the bias; 0: as published",
        1.0,
        [0.0, 1.0],
    ),
];

const HBAO: &[ShapeParameter] = &[
    tuned("strength", "factor of the occlusion", 0.302, [0.0, 10.0], Factors(0.3, 3.0)),
    tuned("power", "exponent of the visibility", 6.41, [0.1, 20.0], Factors(0.5, 12.0)),
    tuned(
        "bias",
        "minimum rise of horizons above the tangent plane, sine",
        0.213,
        [0.0, 1.0],
        Even(0.0, 0.5),
    ),
    tuned("falloff", "exponent of the distance in 1 - r^falloff", 16.0, [0.1, 20.0], Factors(0.5, 16.0)),
];

const ALCHEMY: &[ShapeParameter] = &[
    tuned("sigma", "σ, strength, radii", 0.074, [0.0, 100.0], Factors(0.05, 5.0)),
    tuned("k", "k, exponent of the visibility", 11.9, [0.1, 20.0], Factors(0.5, 12.0)),
    tuned(
        "beta",
        "β, share of the view depth that is subtracted from w·n",
        0.00478,
        [0.0, 1.0],
        Factors(3e-4, 3e-2),
    ),
    tuned("epsilon", "ε, radii²", 0.000313, [1e-6, 10.0], Factors(1e-4, 1.0)),
];

const GTAO: &[ShapeParameter] = &[
    tuned("falloff", "share of the radius beyond which occluders fade", 0.987, [0.0, 0.99], Even(0.0, 0.99)),
    tuned(
        "thin",
        "how much more distances along the view count, so that thin occluders fade",
        0.00496,
        [0.0, 10.0],
        Even(0.0, 2.0),
    ),
    tuned("distribution", "exponent of the taps' distances", 1.485, [0.2, 8.0], Even(1.0, 3.0)),
    tuned("power", "exponent of the visibility", 1.446, [0.1, 20.0], Factors(0.5, 12.0)),
];

const ISSAO: &[ShapeParameter] = &[
    tuned("lambda", "λ, strength", 0.264, [0.0, 100.0], Factors(0.05, 2.0)),
    tuned(
        "phi",
        "φ, the user's contrast, interpreted according to reading=",
        0.236,
        [0.01, 10.0],
        Factors(0.1, 1.0),
    ),
    tuned(
        "psi",
        "ψ, share of the view depth that is subtracted from w·n",
        0.00689,
        [0.0, 1.0],
        Factors(0.001, 0.03),
    ),
    fixed("zcap", "largest view depth that ψ is applied to, radii", 13.0, [0.0, 1000.0]),
    tuned("sigma", "σ, radii²", 0.00489, [0.0, 10.0], Factors(0.0001, 1.0)),
    fixed("reading", "meaning of φ; 1: a factor; 2: the shape of the falloff; 3: contrast", 3.0, [1.0, 3.0]),
    word("attenuation", "off: v normalised, as before the paper (its Fig. 4)", &["off", "on"], 1),
    word(
        "before",
        "how surfaces in front of the sphere of the radius count: not at all, or as if on it",
        &["nothing", "surface"],
        1,
    ),
    word("relation", "relation of e1 and e2: independent, or equal", &["free", "equal"], 1),
];

impl Estimator {
    /// Every estimator.
    pub const ALL: [Self; 5] = [Self::Ssao, Self::Hbao, Self::Alchemy, Self::Issao, Self::Gtao];

    /// The estimator's name in a technique's text.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ssao => "ssao",
            Self::Hbao => "hbao",
            Self::Alchemy => "alchemy",
            Self::Issao => "issao",
            Self::Gtao => "gtao",
        }
    }

    /// The estimator's parameters, in the order of [`super::OcclusionSettings::shape`].
    pub fn parameters(self) -> &'static [ShapeParameter] {
        match self {
            Self::Ssao => SSAO,
            Self::Hbao => HBAO,
            Self::Alchemy => ALCHEMY,
            Self::Issao => ISSAO,
            Self::Gtao => GTAO,
        }
    }
}

impl fmt::Display for Estimator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
