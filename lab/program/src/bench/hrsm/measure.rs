//! One model's results: every technique timed against the others and compared with ray-traced truth.

use std::rc::Rc;

use adumbra_program::exit::Failure;
use adumbra_render::hybrid::twin::level_shares;
use adumbra_render::{
    Answer, FrameTimes, Prepared, RenderError, Renderer, Shot, Stage, TechniqueFiles, build,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::results::{or_nan, pair_or_nan};
use adumbra_compare::Result;
use adumbra_compare::compare::{
    BoundaryGain, CLEAR_TEXELS, Reference, boundary_gain, errors_off_edges, interleaved, median_ratio,
    median_time, near_edges, ratio_range,
};
use adumbra_compare::metrics::factor_errors;
use adumbra_compare::report::{ClearErrors, PixelCounts};
use adumbra_compare::truth::{SunShape, Surfaces};

/// A technique's results; milliseconds are medians.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "HrsmRow")]
pub(crate) struct Row {
    /// Name as given to `--shadow`.
    pub(crate) name: String,
    /// Depth passes.
    pub(crate) depth_ms: f64,
    /// What is built from depth.
    pub(crate) build_ms: f64,
    /// Look-up.
    pub(crate) lookup_ms: f64,
    /// Depth, build and look-up together.
    pub(crate) shadow_ms: f64,
    /// Whole frame, with G-buffer and composite.
    pub(crate) frame_ms: f64,
    /// Shadow time with a cached map, when only the look-up remains.
    pub(crate) still_ms: f64,
    /// Look-up time divided by that of the shadow map at START: the median of the ratios frame by frame.
    #[serde(deserialize_with = "or_nan")]
    #[schemars(with = "Option<f64>")]
    pub(crate) lookup_ratio: f64,
    /// Least and greatest of the ratios that `lookup_ratio` is the median of.
    #[serde(deserialize_with = "pair_or_nan")]
    #[schemars(with = "[Option<f64>; 2]")]
    pub(crate) lookup_ratio_range: [f64; 2],
    /// `shadow_ms` compared with the shadow map at START, the median of the ratios frame by frame.
    #[serde(deserialize_with = "or_nan")]
    #[schemars(with = "Option<f64>")]
    pub(crate) shadow_ratio: f64,
    /// `frame_ms` compared with the shadow map at START, the median of the ratios frame by frame.
    #[serde(deserialize_with = "or_nan")]
    #[schemars(with = "Option<f64>")]
    pub(crate) frame_ratio: f64,
    /// `still_ms` compared with the shadow map at START, the median of the ratios frame by frame.
    #[serde(deserialize_with = "or_nan")]
    #[schemars(with = "Option<f64>")]
    pub(crate) still_ratio: f64,
    /// Whole frame with a cached map, compared with the shadow map at START, the median of the ratios frame
    /// by frame.
    #[serde(deserialize_with = "or_nan")]
    #[schemars(with = "Option<f64>")]
    pub(crate) still_frame_ratio: f64,
    /// GPU memory of a map that is redrawn every frame.
    pub(crate) moving_bytes: u64,
    /// GPU memory of a cached map.
    pub(crate) still_bytes: u64,
    /// `moving_bytes` divided by the bytes of the shadow map at START that is redrawn every frame.
    ///
    /// A cached shadow map is not the reference, because it holds a second layer for moving casters.
    #[serde(deserialize_with = "or_nan")]
    #[schemars(with = "Option<f64>")]
    pub(crate) moving_share: f64,
    /// `still_bytes` divided by the same reference.
    #[serde(deserialize_with = "or_nan")]
    #[schemars(with = "Option<f64>")]
    pub(crate) still_share: f64,
    /// Share of the area that is answered at each level of the map, finest first.
    pub(crate) levels: Option<Vec<f64>>,
    /// Root mean square error of visibility.
    pub(crate) rmse: f64,
    /// Share of the compared pixels that are shadowed but called lit.
    pub(crate) wrong_lit: f64,
    /// Share of the compared pixels that are lit but called shadowed.
    pub(crate) wrong_shadowed: f64,
    /// Errors away from shadow edges.
    pub(crate) clear: ClearErrors,
    /// Gain at shadow edges; `None` for a shadow map.
    pub(crate) boundary: Option<BoundaryGain>,
    /// What the technique skipped on this device.
    pub(crate) notes: Vec<String>,
}

impl Row {
    pub(crate) fn wrong(&self) -> f64 {
        self.wrong_lit + self.wrong_shadowed
    }
}

/// The results of one start and filter.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Group {
    /// Texels per side of the finest level.
    pub(crate) start: u32,
    /// Texels per side of the filter.
    pub(crate) filter: u32,
    /// One row per measurement.
    pub(crate) rows: Vec<Row>,
    /// Techniques that exceed the device's limits or whose reference does, each with the reason.
    pub(crate) skipped: Vec<[String; 2]>,
}

impl Group {
    pub(crate) fn row(&self, name: &str) -> Option<&Row> {
        self.rows.iter().find(|r| r.name == name)
    }
}

/// Returns the technique name of a shadow map.
pub(super) fn plain(size: u32, filter: u32) -> String {
    if filter == 1 { format!("sm:size={size}") } else { format!("pcf:filter={filter}:size={size}") }
}

/// Returns the technique name of a hybrid map.
pub(super) fn hybrid(start: u32, target: u32, filter: u32) -> String {
    format!("hrsm:{start}-{target}:filter={filter}")
}

/// Returns the techniques of a group, each paired with the shadow map at START of equal depth precision.
fn techniques(start: u32, filter: u32, all: bool) -> Vec<[String; 2]> {
    let sm = |size| plain(size, filter);
    let hrsm = |merges: u32| hybrid(start, start >> merges, filter);
    let paper = |merges| format!("{}:test=paper", hrsm(merges));
    let mut names = vec![sm(start), sm(start / 2), sm(start / 4), hrsm(1), hrsm(2), paper(1), paper(2)];
    if all {
        // Texels merged by the paper's test are flat: they need half a coarsest texel of bias, and a slope
        // bias.
        names.extend([hrsm(3), format!("{}:bias=2:slope=2", paper(2))]);
        names.extend(["build=sweep", "layout=paper"].map(|option| format!("{}:{option}", hrsm(2))));
    }
    let mut pairs: Vec<[String; 2]> = names.into_iter().map(|name| [name, sm(start)]).collect();
    if all {
        let beside = format!("{}:depth=16", sm(start));
        pairs.extend([beside.clone(), format!("{}:depth=16", hrsm(2))].map(|name| [name, beside.clone()]));
    }
    pairs
}

/// A model on the device, and its ray-traced truth.
pub(super) struct Measure<'a, 'j, 's> {
    renderer: &'a mut Renderer,
    reference: &'a Reference<'j, 's>,
    shot: Shot,
    surfaces: Surfaces,
    truth: Vec<f32>,
    counted: Vec<bool>,
    pub(super) pixels: PixelCounts,
    /// Whether any frame was timed by wall time.
    pub(super) wall_time: bool,
    /// Masks of the pixels near a shadow edge, each with its distance in world units.
    near: Vec<(f64, Rc<[bool]>)>,
}

/// A technique prepared twice: for a moving light and for a still one.
struct Pair {
    name: String,
    beside: String,
    ready: [Prepared; 2],
    times: [Vec<FrameTimes>; 2],
}

impl<'a, 'j, 's> Measure<'a, 'j, 's> {
    pub(super) fn new(
        renderer: &'a mut Renderer,
        reference: &'a Reference<'j, 's>,
        shot: Shot,
    ) -> Result<Self> {
        let surfaces = reference.cache.surfaces(reference.truth, reference.scene, &shot.camera);
        let sun = (reference.towards_sun, SunShape::Hard);
        let truth =
            reference.cache.factors(reference.truth, reference.scene, &shot.camera, &surfaces, sun.0, sun.1);
        let mut none =
            renderer.prepare(build(renderer.gpu(), &"none".parse()?, TechniqueFiles::default())?)?;
        renderer.draw(&shot, &mut none, Answer::Visibility)?;
        let (pixels, counted) = reference.count(&surfaces, &renderer.read_surface(&shot)?);
        Ok(Self {
            renderer,
            reference,
            shot,
            surfaces,
            truth,
            counted,
            pixels,
            wall_time: false,
            near: Vec::new(),
        })
    }

    /// Times every technique of a start and filter and measures its error; `all` adds the variants.
    pub(super) fn group(&mut self, start: u32, filter: u32, all: bool, frames: u32) -> Result<Group> {
        let (mut pairs, mut skipped) = (Vec::new(), Vec::new());
        for [name, beside] in techniques(start, filter, all) {
            match self.ready(&name, beside) {
                Ok(pair) => pairs.push(pair),
                Err(other @ RenderError::TooLarge { .. }) => skipped.push([name, other.to_string()]),
                Err(other) => return Err(other.into()),
            }
        }
        let mut turns: Vec<&mut Prepared> = pairs.iter_mut().flat_map(|p| &mut p.ready).collect();
        let times = interleaved(self.renderer, &self.shot, &mut turns, frames)?;
        self.wall_time |= times.iter().flatten().any(|t| t.wall_time);
        let mut times = times.into_iter();
        for pair in &mut pairs {
            pair.times = std::array::from_fn(|_| times.next().unwrap_or_default());
        }
        let mut rows = Vec::new();
        for at in 0..pairs.len() {
            let Some(beside) = pairs.iter().position(|p| p.name == pairs[at].beside) else {
                let Pair { name, beside, .. } = &pairs[at];
                skipped.push([name.clone(), format!("its reference {beside} is skipped")]);
                continue;
            };
            let row = self.row(&mut pairs, at, beside)?;
            adumbra_program::note!(
                "{}: {:.1} ms, {:.2} × the shadow map's; {:.3} % wrong",
                row.name,
                row.shadow_ms,
                row.shadow_ratio,
                100.0 * row.wrong()
            );
            rows.push(row);
        }
        Ok(Group { start, filter, rows, skipped })
    }

    /// Builds a technique and draws the frames that create the resources of later frames.
    fn ready(&mut self, name: &str, beside: String) -> Result<Pair, RenderError> {
        let mut make = |text: String, frames: u32| {
            let built = build(self.renderer.gpu(), &text.parse()?, TechniqueFiles::default())?;
            let mut prepared = self.renderer.prepare(built)?;
            for _ in 0..frames {
                self.renderer.draw(&self.shot, &mut prepared, Answer::Visibility)?;
            }
            Ok::<_, RenderError>(prepared)
        };
        // A cached map takes two frames: the first builds the map, the second releases the inputs of the
        // build.
        let ready = [make(name.to_owned(), 1)?, make(format!("{name}:static=cached"), 2)?];
        Ok(Pair { name: name.to_owned(), beside, ready, times: Default::default() })
    }

    fn row(&mut self, pairs: &mut [Pair], at: usize, beside: usize) -> Result<Row> {
        // The cached technique, whose frames draw no depth.
        let kept = &mut pairs[at].ready[1];
        self.renderer.draw(&self.shot, kept, Answer::Visibility)?;
        let factors = self.renderer.read_factor(kept)?;
        let counts = match kept.technique().hybrid() {
            Some(map) => Some((*map.settings(), map.counts(self.renderer.gpu())?)),
            None => None,
        };
        let levels = counts.as_ref().map(|(s, counts)| {
            level_shares(s.start, s.merges(), counts.split)[..=s.merges() as usize].to_vec()
        });
        let boundary = match &counts {
            Some((s, _)) => {
                self.renderer.draw(&self.shot, kept, Answer::Level)?;
                let ends = self.renderer.read_factor(kept)?;
                let texel = kept.technique().texel_world(0.0).unwrap_or(0.0) * f64::from(1 << s.merges());
                let near = self.near(texel);
                let pixels: Vec<usize> = (0..near.len()).filter(|&i| near[i] && self.counted[i]).collect();
                Some(boundary_gain(&ends, s.merges(), &pixels))
            }
            None => None,
        };
        let nothing = || {
            Failure::BadInput("no pixel of this view can be compared, or all of them are near a shadow edge; give a larger --size".to_owned())
        };
        let errors = factor_errors(&factors, &self.truth, |i| self.counted[i])?.ok_or_else(nothing)?;
        let texel = pairs[at].ready[0].technique().texel_world(0.0).unwrap_or(0.0);
        let near = self.near(CLEAR_TEXELS * texel);
        let is_compared = |i: usize| self.counted[i];
        let clear = errors_off_edges(&factors, &self.truth, is_compared, &near).ok_or_else(nothing)?;
        let (own, other) = (&pairs[at], &pairs[beside]);
        let [moving, still] = &own.times;
        let bytes = |pair: &Pair| [0, 1].map(|i: usize| pair.ready[i].technique().bytes());
        let ([moving_bytes, still_bytes], of) = (bytes(own), bytes(other));
        let lookup = |t: &FrameTimes| t.of(Stage::Lookup);
        let frame = |t: &FrameTimes| t.milliseconds.iter().sum::<f64>();
        Ok(Row {
            name: own.name.clone(),
            depth_ms: median_time(moving, |t| t.of(Stage::Depth)),
            build_ms: median_time(moving, |t| t.of(Stage::Build)),
            lookup_ms: median_time(moving, lookup),
            shadow_ms: median_time(moving, FrameTimes::shadow),
            frame_ms: median_time(moving, frame),
            still_ms: median_time(still, FrameTimes::shadow),
            lookup_ratio: median_ratio(moving, &other.times[0], lookup),
            lookup_ratio_range: ratio_range(moving, &other.times[0], lookup),
            shadow_ratio: median_ratio(moving, &other.times[0], FrameTimes::shadow),
            frame_ratio: median_ratio(moving, &other.times[0], frame),
            still_ratio: median_ratio(still, &other.times[1], FrameTimes::shadow),
            still_frame_ratio: median_ratio(still, &other.times[1], frame),
            moving_bytes,
            still_bytes,
            moving_share: moving_bytes as f64 / of[0] as f64,
            still_share: still_bytes as f64 / of[0] as f64,
            levels,
            rmse: errors.rmse,
            wrong_lit: errors.wrong_lit,
            wrong_shadowed: errors.wrong_shadowed,
            clear,
            boundary,
            notes: own.ready[0].technique().notes(),
        })
    }

    /// Returns a mask of the pixels within `radius_world` of an edge of the true shadow.
    fn near(&mut self, radius_world: f64) -> Rc<[bool]> {
        if let Some((_, known)) = self.near.iter().find(|(r, _)| r.to_bits() == radius_world.to_bits()) {
            return known.clone();
        }
        let found = near_edges(&self.surfaces, &self.truth, self.reference.towards_sun, radius_world);
        let found: Rc<[bool]> = found.into();
        self.near.push((radius_world, found.clone()));
        found
    }
}
