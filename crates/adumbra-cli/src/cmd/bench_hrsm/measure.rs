//! One model's figures: every technique timed beside the others, and judged by rays.

use std::rc::Rc;

use adumbra_lab::compare::{
    BoundaryGain, CLEAR_TEXELS, Judge, boundary_gain, errors_off_edges, interleaved, median_ratio,
    median_time, near_flips, ratio_range,
};
use adumbra_lab::metrics::factor_errors;
use adumbra_lab::report::{ClearErrors, PixelCounts};
use adumbra_lab::truth::{SunShape, Surfaces};
use adumbra_render::hybrid::twin::level_shares;
use adumbra_render::{Answer, Baked, FrameTimes, Prepared, RenderError, Renderer, Shot, Stage, build};
use serde::Serialize;

use crate::exit::Failure;

/// A technique's figures; milliseconds are medians.
#[derive(Serialize)]
pub(super) struct Row {
    /// As `--shadow` takes it.
    pub(super) name: String,
    pub(super) depth_ms: f64,
    pub(super) build_ms: f64,
    pub(super) lookup_ms: f64,
    /// The three together.
    pub(super) shadow_ms: f64,
    /// With G-buffer and composite.
    pub(super) frame_ms: f64,
    /// The look-up when nothing else is left to do.
    pub(super) still_ms: f64,
    /// Look-up, shadow, frame, still and its frame by those of the shadow map at START, frame by frame.
    pub(super) lookup_ratio: f64,
    /// Least and most of the frames that the look-up's is the median of.
    pub(super) lookup_ratio_range: [f64; 2],
    pub(super) shadow_ratio: f64,
    pub(super) frame_ratio: f64,
    pub(super) still_ratio: f64,
    pub(super) still_frame_ratio: f64,
    pub(super) moving_bytes: u64,
    pub(super) still_bytes: u64,
    /// Of the bytes of the shadow map at START that is drawn anew: kept ones hold a second layer for what moves.
    pub(super) moving_share: f64,
    pub(super) still_share: f64,
    /// Share of the area that each of the map's levels answers for, the finest first.
    pub(super) levels: Option<Vec<f64>>,
    pub(super) rmse: f64,
    /// Shares of the compared pixels.
    pub(super) wrong_lit: f64,
    pub(super) wrong_shadowed: f64,
    pub(super) clear: ClearErrors,
    pub(super) boundary: Option<BoundaryGain>,
    pub(super) notes: Vec<String>,
}

impl Row {
    pub(super) fn wrong(&self) -> f64 {
        self.wrong_lit + self.wrong_shadowed
    }
}

/// One start and filter.
#[derive(Serialize)]
pub(super) struct Group {
    pub(super) start: u32,
    pub(super) filter: u32,
    pub(super) rows: Vec<Row>,
    /// What is larger than the device takes, and why.
    pub(super) left_out: Vec<[String; 2]>,
}

impl Group {
    pub(super) fn row(&self, name: &str) -> Option<&Row> {
        self.rows.iter().find(|r| r.name == name)
    }
}

/// A shadow map as a technique.
pub(super) fn plain(size: u32, filter: u32) -> String {
    if filter == 1 { format!("sm:size={size}") } else { format!("pcf:filter={filter}:size={size}") }
}

/// A hybrid map as a technique.
pub(super) fn hybrid(start: u32, target: u32, filter: u32) -> String {
    format!("hrsm:{start}-{target}:filter={filter}")
}

/// Techniques of a group, each with its shadow map at START of the same depth.
fn techniques(start: u32, filter: u32, all: bool) -> Vec<[String; 2]> {
    let sm = |size| plain(size, filter);
    let hrsm = |merges: u32| hybrid(start, start >> merges, filter);
    let paper = |merges| format!("{}:test=paper", hrsm(merges));
    let mut names = vec![sm(start), sm(start / 2), sm(start / 4), hrsm(1), hrsm(2), paper(1), paper(2)];
    if all {
        // Merged texels of the paper's test are flat: a bias of half a coarsest texel, and one that grows with the slope.
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

/// A model on the device, and its truth.
pub(super) struct Measure<'a, 'j, 's> {
    renderer: &'a mut Renderer,
    judge: &'a Judge<'j, 's>,
    shot: Shot,
    surfaces: Surfaces,
    truth: Vec<f32>,
    counted: Vec<bool>,
    pub(super) pixels: PixelCounts,
    /// A frame was timed by the wall.
    pub(super) wall_time: bool,
    /// Which pixels lie near an edge, by how near.
    near: Vec<(f64, Rc<[bool]>)>,
}

/// A technique, once for a light that moves and once for one that does not.
struct Pair {
    name: String,
    beside: String,
    ready: [Prepared; 2],
    times: [Vec<FrameTimes>; 2],
}

impl<'a, 'j, 's> Measure<'a, 'j, 's> {
    pub(super) fn new(
        renderer: &'a mut Renderer,
        judge: &'a Judge<'j, 's>,
        shot: Shot,
    ) -> Result<Self, Failure> {
        let surfaces = judge.cache.surfaces(judge.truth, judge.scene, &shot.camera);
        let sun = (judge.towards_sun, SunShape::Hard);
        let truth = judge.cache.factors(judge.truth, judge.scene, &shot.camera, &surfaces, sun.0, sun.1);
        let mut none = renderer.prepare(build(renderer.gpu(), &"none".parse()?, Baked::default())?)?;
        renderer.draw(&shot, &mut none, Answer::Visibility)?;
        let (pixels, counted) = judge.count(&surfaces, &renderer.read_surface(&shot)?);
        Ok(Self {
            renderer,
            judge,
            shot,
            surfaces,
            truth,
            counted,
            pixels,
            wall_time: false,
            near: Vec::new(),
        })
    }

    /// Times and judges every technique of a start and filter; `all` adds the variants.
    pub(super) fn group(
        &mut self,
        start: u32,
        filter: u32,
        all: bool,
        frames: u32,
    ) -> Result<Group, Failure> {
        let (mut pairs, mut left_out) = (Vec::new(), Vec::new());
        for [name, beside] in techniques(start, filter, all) {
            match self.ready(&name, beside) {
                Ok(pair) => pairs.push(pair),
                Err(other @ RenderError::TooLarge { .. }) => left_out.push([name, other.to_string()]),
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
                left_out.push([name.clone(), format!("{beside}, which it is held against, is left out")]);
                continue;
            };
            let row = self.row(&mut pairs, at, beside)?;
            eprintln!(
                "{}: {:.1} ms, of the map's {:.2}; {:.3} % wrong",
                row.name,
                row.shadow_ms,
                row.shadow_ratio,
                100.0 * row.wrong()
            );
            rows.push(row);
        }
        Ok(Group { start, filter, rows, left_out })
    }

    /// Makes a technique and draws what later frames keep.
    fn ready(&mut self, name: &str, beside: String) -> Result<Pair, RenderError> {
        let mut make = |text: String, frames: u32| {
            let built = build(self.renderer.gpu(), &text.parse()?, Baked::default())?;
            let mut prepared = self.renderer.prepare(built)?;
            for _ in 0..frames {
                self.renderer.draw(&self.shot, &mut prepared, Answer::Visibility)?;
            }
            Ok::<_, RenderError>(prepared)
        };
        // The first frame makes the map, the second lets go of what made it.
        let ready = [make(name.to_owned(), 1)?, make(format!("{name}:static=cached"), 2)?];
        Ok(Pair { name: name.to_owned(), beside, ready, times: Default::default() })
    }

    fn row(&mut self, pairs: &mut [Pair], at: usize, beside: usize) -> Result<Row, Failure> {
        // The kept one: its frames draw no depth.
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
        let nothing =
            || Failure::BadInput("no pixel of this view is compared, or none lies off the edges".to_owned());
        let errors = factor_errors(&factors, &self.truth, |i| self.counted[i])?.ok_or_else(nothing)?;
        let texel = pairs[at].ready[0].technique().texel_world(0.0).unwrap_or(0.0);
        let near = self.near(CLEAR_TEXELS * texel);
        let judged = |i: usize| self.counted[i];
        let clear = errors_off_edges(&factors, &self.truth, judged, &near).ok_or_else(nothing)?;
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

    /// Pixels within `radius_world` of an edge of the true shadow.
    fn near(&mut self, radius_world: f64) -> Rc<[bool]> {
        if let Some((_, known)) = self.near.iter().find(|(r, _)| r.to_bits() == radius_world.to_bits()) {
            return known.clone();
        }
        let found = near_flips(&self.surfaces, &self.truth, self.judge.towards_sun, radius_world);
        let found: Rc<[bool]> = found.into();
        self.near.push((radius_world, found.clone()));
        found
    }
}
