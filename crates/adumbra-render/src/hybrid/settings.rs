//! What a hybrid map is made of, and from a technique's text to it: `hrsm:4096-1024:test=paper:filter=5`.

use adumbra_shaders::constants::{HYBRID_LAST_SLOPE, HYBRID_ONE, HYBRID_SLOPE_BITS, MAX_SLOPE};
use adumbra_shaders::{Source, source};

use crate::error::{RenderError, Result};
use crate::maps::{DepthPrecision, MapBias, MapFilter, cache_static};
use crate::technique::{SpecReader, TechniqueSpec};

/// Finest resolutions, texels a side.
const STARTS: [u32; 6] = [256, 512, 1024, 2048, 4096, 8192];
/// Of each its half, quarter and eighth.
const SIZES: [&str; 18] = [
    "256-128",
    "256-64",
    "256-32",
    "512-256",
    "512-128",
    "512-64",
    "1024-512",
    "1024-256",
    "1024-128",
    "2048-1024",
    "2048-512",
    "2048-256",
    "4096-2048",
    "4096-1024",
    "4096-512",
    "8192-4096",
    "8192-2048",
    "8192-1024",
];
/// 4096-1024.
const DEFAULT_SIZES: usize = 13;
/// The paper advises against finer levels below this.
const ADVISED_START: u32 = 1024;
/// How far a merged plane may lie behind its texels unless told otherwise, texels.
const TOLERANCE_TEXELS: f64 = 0.5;

/// When four texels become one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MergeTest {
    /// A plane fits: no finest texel lies behind it, and none further before it than this, measured in finest texels' edges.
    Plane {
        /// At least 0.
        tolerance_texels: f64,
    },
    /// The paper's equation 1: no depth differs from the mean of the four by more than a quarter of itself.
    Paper,
}

impl MergeTest {
    /// The file that says what texels that merged hold.
    pub(super) fn leaf(self) -> Source {
        match self {
            Self::Plane { .. } => source::HYBRID_PLANE,
            Self::Paper => source::HYBRID_MEAN,
        }
    }
}

/// How a map's texels are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HybridLayout {
    /// 32 bits a texel.
    Compact,
    /// The paper's: 128 bits a texel, with its coordinate and normal, and a list that leads to finer ones.
    Paper,
}

/// Which pass merges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildKind {
    /// A thread a strip of blocks, as in the paper.
    Sweep,
    /// A thread a block.
    Blocks,
}

/// A hybrid map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HybridSettings {
    /// Finest texels a side, a power of two.
    pub start: u32,
    /// Coarsest texels a side: an eighth to a half of `start`.
    pub target: u32,
    /// When texels merge.
    pub test: MergeTest,
    /// Of the shadow map that it is made from, and of its finest texels.
    pub depth: DepthPrecision,
    /// How it is stored.
    pub layout: HybridLayout,
    /// How it is built.
    pub build: BuildKind,
    /// Nearest, or percentage closer over 3, 5 or 7 finest texels.
    pub filter: MapFilter,
    /// How the receiver is moved, in finest texels.
    pub bias: MapBias,
    /// Keep the map, in no more memory than it needs, until light or casters change.
    pub cache_static: bool,
}

impl HybridSettings {
    /// The settings that a technique's text asks for.
    ///
    /// # Errors
    /// [`crate::RenderError::Technique`] for a value out of range, or an unknown key.
    pub fn from_spec(spec: &TechniqueSpec) -> Result<Self> {
        let mut reader = spec.reader();
        let settings = Self::from_reader(&mut reader)?;
        reader.finish()?;
        Ok(settings)
    }

    pub(crate) fn from_reader(reader: &mut SpecReader<'_>) -> Result<Self> {
        let sizes = "START-TARGET: finest and coarsest texels a side; TARGET is a half, quarter or eighth";
        let place = reader.place("sizes", sizes, DEFAULT_SIZES, &SIZES)?;
        let start = STARTS[place / 3];
        let what = "finest texels a side that are compared";
        let width = reader.integer("filter", what, 5, &[1, 3, 5, 7])?;
        let filter = if width == 1 { MapFilter::Nearest } else { MapFilter::Pcf { width } };
        let test = "what merges: texels on a plane, or by the paper's equation 1";
        let tolerance = "of test=plane: how far a texel may lie behind the plane, texels";
        let test = match reader.choice("test", test, &["plane", "paper"])? {
            "paper" => MergeTest::Paper,
            _ => MergeTest::Plane {
                tolerance_texels: reader.number("tolerance", tolerance, TOLERANCE_TEXELS, 0.0..=64.0)?,
            },
        };
        Ok(Self {
            start,
            target: start >> (place % 3 + 1),
            test,
            depth: DepthPrecision::from_reader(reader)?,
            layout: match reader.choice(
                "layout",
                "texels of 32 bits, or the paper's of 128",
                &["compact", "paper"],
            )? {
                "paper" => HybridLayout::Paper,
                _ => HybridLayout::Compact,
            },
            build: match reader.choice(
                "build",
                "a thread a block, or a strip of them",
                &["blocks", "sweep"],
            )? {
                "sweep" => BuildKind::Sweep,
                _ => BuildKind::Blocks,
            },
            filter,
            bias: MapBias::from_reader(reader, &filter)?,
            cache_static: cache_static(reader)?,
        })
    }

    /// Whether a map can be built of these settings.
    ///
    /// # Errors
    /// [`RenderError::Technique`] where START is no power of two up to 16,384, TARGET not its half, quarter or eighth and at least 2,
    /// the filter neither nearest nor percentage closer over 3, 5 or 7 texels, the tolerance negative or no number.
    pub fn check(&self) -> Result<()> {
        let wrong = |reason: String| Err(RenderError::Technique { name: "hrsm".to_owned(), reason });
        let Self { start, target, .. } = *self;
        let merges = (1..=3).any(|k| start >> k == target);
        if !start.is_power_of_two() || start > 16384 || target < 2 || !merges {
            return wrong(format!("{start}-{target}: TARGET is a half, quarter or eighth of START"));
        }
        if !matches!(self.filter, MapFilter::Nearest | MapFilter::Pcf { width: 3 | 5 | 7 }) {
            return wrong(format!("it has no filter {:?}", self.filter));
        }
        match self.test {
            MergeTest::Plane { tolerance_texels: t } if !(t >= 0.0 && t.is_finite()) => {
                wrong(format!("a tolerance of {t} texels"))
            }
            _ => Ok(()),
        }
    }

    /// Levels above the finest.
    pub fn merges(&self) -> u32 {
        (self.start / self.target).ilog2()
    }

    /// Width of the filter in finest texels.
    pub fn width(&self) -> u32 {
        match self.filter {
            MapFilter::Pcf { width } => width,
            _ => 1,
        }
    }

    /// What the user should know of these settings.
    pub(super) fn notes(&self) -> Vec<String> {
        if self.start >= ADVISED_START {
            return Vec::new();
        }
        vec![format!(
            "the paper advises against a START below {ADVISED_START}, here {}: edges are as coarse as its texels",
            self.start
        )]
    }
}

/// What planes are measured in, in whole-number depth: slope of code 1 and tolerance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneUnits {
    /// Depth of slope code 1, in 4096ths of a step a texel.
    pub slope: i32,
    /// Twice the tolerance, steps.
    pub tolerance: i32,
}

impl PlaneUnits {
    /// For texels whose edge is `texel_depth` of the depth range.
    pub fn new(test: MergeTest, texel_depth: f64) -> Self {
        let texel_steps = texel_depth * f64::from(HYBRID_ONE);
        let last = f64::from(HYBRID_LAST_SLOPE * HYBRID_LAST_SLOPE);
        let slope = f64::from(1 << HYBRID_SLOPE_BITS) * f64::from(MAX_SLOPE) * texel_steps / last;
        let tolerance = match test {
            MergeTest::Plane { tolerance_texels } => 2.0 * tolerance_texels * texel_steps,
            MergeTest::Paper => 0.0,
        };
        Self {
            // Squares of codes times this stay within 31 bits.
            slope: slope.round().clamp(1.0, f64::from(1 << 19)) as i32,
            tolerance: tolerance.min(f64::from(1 << 24)) as i32,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(text: &str) -> Result<HybridSettings> {
        HybridSettings::from_spec(&text.parse()?)
    }

    #[test]
    fn spec_reads_every_key() {
        let s =
            settings("hrsm:2048-256:test=paper:depth=16:build=sweep:filter=1:static=cached:bias=2").unwrap();
        assert_eq!((s.start, s.target, s.merges(), s.width()), (2048, 256, 3, 1));
        assert_eq!((s.test, s.build, s.depth), (MergeTest::Paper, BuildKind::Sweep, DepthPrecision::Bits16));
        assert!(s.cache_static && s.bias.constant_texels == 2.0);
        let s = settings("hrsm").unwrap();
        assert_eq!((s.start, s.target, s.width()), (4096, 1024, 5));
        assert_eq!((s.test, s.layout), (MergeTest::Plane { tolerance_texels: 0.5 }, HybridLayout::Compact));
        assert_eq!(settings("hrsm:layout=paper").unwrap().layout, HybridLayout::Paper);
    }

    #[test]
    fn spec_reads_every_pair_of_sizes() {
        for sizes in SIZES {
            let s = settings(&format!("hrsm:{sizes}")).unwrap();
            assert_eq!(format!("{}-{}", s.start, s.target), sizes);
            s.check().unwrap();
        }
    }

    #[test]
    fn spec_refuses_what_cannot_be() {
        for text in [
            "hrsm:4096-4096",
            "hrsm:4096-256",
            "hrsm:1000-500",
            "hrsm:4096",
            "hrsm:filter=2",
            "hrsm:test=mean",
            "hrsm:layout=wide",
            "hrsm:test=paper:tolerance=1",
        ] {
            assert!(settings(text).is_err(), "{text}");
        }
    }

    #[test]
    fn check_refuses_what_text_cannot_say() {
        let good = settings("hrsm:1024-256").unwrap();
        good.check().unwrap();
        let bad = [
            HybridSettings { target: 1024, ..good },
            HybridSettings { target: 0, ..good },
            HybridSettings { start: 0, target: 0, ..good },
            HybridSettings { start: 1000, target: 500, ..good },
            HybridSettings { filter: MapFilter::Pcf { width: 2 }, ..good },
            HybridSettings { filter: MapFilter::Poisson { radius: 2.0 }, ..good },
            HybridSettings { test: MergeTest::Plane { tolerance_texels: f64::NAN }, ..good },
        ];
        for s in bad {
            assert!(s.check().is_err(), "{s:?}");
        }
    }

    #[test]
    fn starts_below_the_advised_are_warned_of() {
        assert!(settings("hrsm:1024-512").unwrap().notes().is_empty());
        assert!(settings("hrsm:512-256").unwrap().notes()[0].contains("advises against"));
    }

    #[test]
    fn plane_units_reach_the_steepest_slope() {
        let units = PlaneUnits::new(MergeTest::Plane { tolerance_texels: 0.5 }, 1.0 / 4096.0);
        let steepest = f64::from(HYBRID_LAST_SLOPE * HYBRID_LAST_SLOPE) * f64::from(units.slope) / 4096.0;
        assert!((steepest / 4096.0 - f64::from(MAX_SLOPE)).abs() < 0.01, "{steepest}");
        assert_eq!(units.tolerance, 4096);
    }
}
