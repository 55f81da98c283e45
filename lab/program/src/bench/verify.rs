//! `adumbra-lab bench verify`: compares files of several scenes under several suns with rays.

use adumbra::{Filter, Sun};
use adumbra_bake::{AssumeGround, BakeOptions, Size};
use adumbra_program::exit::Code;
use adumbra_program::output::make_folder;
use adumbra_program::scene::load_scene;
use adumbra_scene::LoadOptions;
use adumbra_truth::trace::{TraceOptions, Tracer};
use adumbra_truth::verify::{
    Class, ClassResult, Sampler, Solids, SurfaceSampler, Verification, Verifier, VerifyOptions, VolumeSampler,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{DEFAULT_SUN, say_tables, write};
use crate::args::BenchVerify;
use crate::light_file::{Kind, LightFile};
use adumbra_compare::Result;
use adumbra_html::page::Table;
use adumbra_program::format::percent;

/// All results.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub(crate) struct VerifyResults {
    /// Voxels along the longer side of each grid.
    resolution: u64,
    /// One row per scene, sun, layout and filter.
    rows: Vec<Row>,
}

/// One file looked up with one filter.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "VerifyRow")]
struct Row {
    /// Name of the scene.
    scene: String,
    /// Elevation of the sun, or its direction.
    sun: String,
    /// Layout of the file.
    layout: String,
    /// Texels per side of the filter.
    filter: u32,
    /// Whether every class keeps its promise.
    holds: bool,
    /// What `verify` found.
    figures: Verification,
}

/// Elevations of the other suns above the horizon in degrees, from overhead to nearly level.
const ELEVATIONS_DEGREES: [f64; 6] = [90.0, 60.0, 10.0, 5.0, 3.0, 2.0];
/// Azimuth of the other suns, degrees clockwise from -Z.
const AZIMUTH_DEGREES: f64 = 55.0;

fn suns() -> Result<Vec<(String, Sun)>> {
    let mut suns = vec![("(0.5, 0.8, 0.35)".to_owned(), Sun::from_direction(DEFAULT_SUN)?)];
    for elevation in ELEVATIONS_DEGREES {
        suns.push((format!("elevation {elevation}°"), Sun::from_angles(AZIMUTH_DEGREES, elevation)?));
    }
    Ok(suns)
}

pub(super) fn run(args: &BenchVerify) -> Result<Code> {
    make_folder(&args.output)?;
    let mut rows = Vec::new();
    let mut all_hold = true;
    for name in &args.names {
        let load = LoadOptions { allow_outside: args.folder.allow_outside, ..LoadOptions::default() };
        let scene = load_scene(&args.folder.scenes.join(name), &load)?;
        let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha: false });
        let solids = Solids::of(&scene);
        for (sun_name, sun) in suns()? {
            let options = BakeOptions::new(sun, Size::Resolution(args.resolution))
                .with(|o| o.assume_ground = if args.volume { AssumeGround::No } else { AssumeGround::Auto });
            let [packed, quadtree] = Kind::ALL.map(|kind| LightFile::bake(&scene, &options, kind));
            let files = [packed?, quadtree?];
            let sampler = if args.volume {
                Sampler::Volume(VolumeSampler::new(files[0].grid()))
            } else {
                Sampler::Surface(SurfaceSampler::new(&scene, &solids, sun.towards(), false))
            };
            for file in &files {
                let layout = file.kind().name();
                for &filter in &args.filter {
                    let answers = file.answers(Filter::try_from(filter)?);
                    let options = VerifyOptions { samples: args.samples, seed: 1 };
                    let v = Verifier::new(&answers, &tracer, &solids).run(&sampler, &options);
                    all_hold &= v.holds();
                    adumbra_program::note!(
                        "{name} {sun_name} {layout} K = {filter}: interior {:.5}, grazing {:.5}{}",
                        v.interior_agreement,
                        v.class(Class::Grazing).agreement,
                        if v.holds() { "" } else { ", does not hold" }
                    );
                    rows.push(Row {
                        scene: name.clone(),
                        sun: sun_name.clone(),
                        layout: layout.to_owned(),
                        filter,
                        holds: v.holds(),
                        figures: v,
                    });
                }
            }
        }
    }
    let stem = if args.volume { "verify-volume" } else { "verify" };
    let document = VerifyResults { resolution: args.resolution, rows };
    write(&args.output, stem, &table(args, &document), &document)?;
    say_tables(&args.output, stem);
    Ok(if all_hold { Code::Fine } else { Code::CheckFailed })
}

fn table(args: &BenchVerify, document: &VerifyResults) -> String {
    let table = Table::of(
        "",
        &document.rows,
        &[
            ("scene", |r| r.scene.clone()),
            ("sun", |r| r.sun.clone()),
            ("layout", |r| r.layout.clone()),
            ("K", |r| r.filter.to_string()),
            ("all", |r| percent(r.figures.agreement, 3)),
            ("interior", |r| r.agreement(Class::Interior)),
            ("grazing", |r| r.agreement(Class::Grazing)),
            ("edge: misplaced", |r| r.misplaced(Class::Edge)),
            ("narrow: misplaced", |r| r.misplaced(Class::Narrow)),
            ("thin", |r| r.agreement(Class::Thin)),
            ("edge-on", |r| r.agreement(Class::EdgeOn)),
            ("acne", |r| percent(r.figures.acne, 3)),
            ("leak", |r| percent(r.figures.leak, 3)),
            ("holds", |r| if r.holds { "yes" } else { "no" }.to_owned()),
        ],
    );
    format!(
        "# Agreement with rays{}\n\nN = {}, {} random points per row. `adumbra_truth::verify` defines the \
        classes. Agreement is in % of the points of a class; with a filter of K × K texels, it is 100 minus the \
        mean difference from the rays' own mean. The share of the compared points that are in the class follows \
        in brackets. For edges and narrow features, the figure is the share that rays at the texel's centre do not explain either.\n\n{}",
        if args.volume { ", points in free space" } else { "" },
        document.resolution,
        args.samples,
        table.markdown()
    )
}

impl Row {
    fn agreement(&self, class: Class) -> String {
        match self.figures.class(class) {
            c if c.points == 0 => "–".to_owned(),
            c => format!("{:.4} ({:.1})", 100.0 * c.agreement, self.points_percent(c)),
        }
    }

    fn misplaced(&self, class: Class) -> String {
        match self.figures.class(class) {
            c if c.points == 0 || self.filter != 1 => "–".to_owned(),
            c => format!("{:.3} ({:.1})", 100.0 * c.misplaced_share(), self.points_percent(c)),
        }
    }

    fn points_percent(&self, class: &ClassResult) -> f64 {
        100.0 * class.points as f64 / self.figures.samples as f64
    }
}
