//! Settings of a hybrid map, and their parsing from a technique's text, such as
//! `hrsm:4096-1024:test=paper:filter=5`.

use adumbra_shaders::constants::{HYBRID_LAST_SLOPE, HYBRID_ONE, HYBRID_SLOPE_BITS, MAX_SLOPE};
use adumbra_shaders::{Source, source};

use crate::error::{RenderError, Result};
use crate::maps::{DepthPrecision, MapBias, MapFilter, cache_static};
use crate::technique::{SpecReader, SpecText};

/// Finest resolutions, texels per side.
const STARTS: [u32; 6] = [256, 512, 1024, 2048, 4096, 8192];
/// Pairs START-TARGET: each entry of [`STARTS`] with its half, quarter and eighth.
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
/// Index of 4096-1024 in [`SIZES`].
const DEFAULT_SIZES: usize = 13;
/// The smallest START that the paper advises, texels per side.
const ADVISED_START: u32 = 1024;
/// Default tolerance of [`MergeTest::Plane`]: how far a merged plane may lie behind its texels, texels.
const TOLERANCE_TEXELS: f64 = 0.5;

/// The test that decides whether four texels merge into one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MergeTest {
    /// Texels merge if a plane fits: no finest texel lies behind it, and none lies further in front of it
    /// than the tolerance.
    Plane {
        /// In edge lengths of a finest texel, at least 0.
        tolerance_texels: f64,
    },
    /// The paper's equation 1: each of the four depths differs from their mean by at most a quarter of
    /// itself.
    Paper,
}

impl MergeTest {
    /// The WGSL file that decodes merged texels.
    pub(super) fn leaf(self) -> Source {
        match self {
            Self::Plane { .. } => source::HYBRID_PLANE,
            Self::Paper => source::HYBRID_MEAN,
        }
    }
}

/// The memory layout of a map's texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HybridLayout {
    /// 32 bits per texel.
    Compact,
    /// The paper's: 128 bits per texel, with its coordinates and normal, and lists of links to finer texels.
    Paper,
}

/// The pass that merges texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildKind {
    /// One thread per strip of blocks, as in the paper.
    Sweep,
    /// One thread per block.
    Blocks,
}

/// Settings of a hybrid map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HybridSettings {
    /// Finest resolution, texels per side, a power of two.
    pub start: u32,
    /// Coarsest resolution, texels per side: an eighth to a half of `start`.
    pub target: u32,
    /// The test that decides which texels merge.
    pub test: MergeTest,
    /// Depth precision of the source shadow map and of the finest texels.
    pub depth: DepthPrecision,
    /// The memory layout.
    pub layout: HybridLayout,
    /// The pass that merges texels.
    pub build: BuildKind,
    /// Nearest, or percentage-closer filtering over 3, 5 or 7 finest texels.
    pub filter: MapFilter,
    /// The receiver's bias, in finest texels.
    pub bias: MapBias,
    /// Whether to keep the map, in no more memory than it needs, until the light or the casters change.
    pub cache_static: bool,
}

impl HybridSettings {
    /// Parses the settings from a technique's text.
    ///
    /// # Errors
    /// Returns [`crate::RenderError::Technique`] if a value is out of range or a key is unknown.
    pub fn from_spec(spec: &SpecText) -> Result<Self> {
        spec.read(Self::from_reader)
    }

    pub(crate) fn from_reader(reader: &mut SpecReader<'_>) -> Result<Self> {
        let sizes = "START-TARGET: texels per side of the finest and the coarsest level; TARGET is a half, quarter or eighth of START";
        let place = reader.place("sizes", sizes, DEFAULT_SIZES, &SIZES)?;
        let start = STARTS[place / 3];
        let what = "finest texels per side that are compared";
        let width = reader.integer("filter", what, 5, &[1, 3, 5, 7])?;
        let filter = if width == 1 { MapFilter::Nearest } else { MapFilter::Pcf { width } };
        let test = "which texels merge: those that a plane fits, or those that meet the paper's equation 1";
        let tolerance = "with test=plane: how far the plane may be behind a texel, texels";
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
                "32-bit texels, or the paper's of 128 bits",
                &["compact", "paper"],
            )? {
                "paper" => HybridLayout::Paper,
                _ => HybridLayout::Compact,
            },
            build: match reader.choice(
                "build",
                "one thread per block, or per strip of blocks",
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

    /// Checks that a map can be built with these settings.
    ///
    /// # Errors
    /// Returns [`RenderError::Technique`] if START is not a power of two up to 16,384, if TARGET is not its
    /// half, quarter or eighth or is less than 2, if the filter is neither nearest nor percentage-closer over
    /// 3, 5 or 7 texels, or if the tolerance is negative or not finite.
    pub fn check(&self) -> Result<()> {
        let wrong = |reason: String| Err(RenderError::Technique { name: "hrsm".to_owned(), reason });
        let Self { start, target, .. } = *self;
        let merges = (1..=3).any(|k| start >> k == target);
        if !start.is_power_of_two() || start > 16384 || target < 2 || !merges {
            return wrong(format!("{start}-{target}: TARGET is a half, quarter or eighth of START"));
        }
        if !matches!(self.filter, MapFilter::Nearest | MapFilter::Pcf { width: 3 | 5 | 7 }) {
            return wrong(format!("filter {:?} is not supported", self.filter));
        }
        match self.test {
            MergeTest::Plane { tolerance_texels: t } if !(t >= 0.0 && t.is_finite()) => {
                wrong(format!("a tolerance of {t} texels; it must be finite and at least 0"))
            }
            _ => Ok(()),
        }
    }

    /// Number of levels above the finest.
    pub fn merges(&self) -> u32 {
        (self.start / self.target).ilog2()
    }

    /// Width of the filter, in finest texels.
    pub fn width(&self) -> u32 {
        match self.filter {
            MapFilter::Pcf { width } => width,
            _ => 1,
        }
    }

    /// Advice to the user about these settings.
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

/// Units of merged planes in fixed-point depth, whose step is 1 / `HYBRID_ONE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlaneUnits {
    /// Slope of code 1, in 4096ths of a step per texel.
    pub slope: i32,
    /// Twice the tolerance, in steps.
    pub tolerance: i32,
}

impl PlaneUnits {
    /// Returns the units for texels whose edge is `texel_depth` of the depth range.
    pub fn new(test: MergeTest, texel_depth: f64) -> Self {
        let texel_steps = texel_depth * f64::from(HYBRID_ONE);
        let last = f64::from(HYBRID_LAST_SLOPE * HYBRID_LAST_SLOPE);
        let slope = f64::from(1 << HYBRID_SLOPE_BITS) * f64::from(MAX_SLOPE) * texel_steps / last;
        let tolerance = match test {
            MergeTest::Plane { tolerance_texels } => 2.0 * tolerance_texels * texel_steps,
            MergeTest::Paper => 0.0,
        };
        Self {
            // Keeps the square of a code times this within 31 bits.
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
    fn spec_rejects_invalid_values() {
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
    fn check_rejects_settings_that_text_cannot_express() {
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
    fn notes_warn_of_starts_below_the_advised() {
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
