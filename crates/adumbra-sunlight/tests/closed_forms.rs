//! Hours beside a gnomon, a wall, between two walls, below an overhang and in a court, at four latitudes on
//! three days, against the same shadows in closed form: a box hides the sun where the ray is within all three
//! pairs of its planes at once.

use adumbra_scene::{Mesh, Scene};
use adumbra_solar::{Atmosphere, Day, Location, position};
use adumbra_sunlight::points::Facing;
use adumbra_sunlight::{Receiver, Suns, Watch};
use adumbra_testing::{cuboid, scene_of};
use adumbra_truth::trace::{TraceOptions, Tracer};

/// A box: its lowest and its highest corner.
type Block = [[f32; 3]; 2];

/// A shape, and a point with the normal of its surface.
struct Form {
    name: &'static str,
    blocks: Vec<Block>,
    point: [f64; 3],
    normal: [f64; 3],
}

const UP: [f64; 3] = [0.0, 1.0, 0.0];
const SOUTH: [f64; 3] = [0.0, 0.0, 1.0];

fn forms() -> Vec<Form> {
    let form = |name, blocks: &[Block], point, normal| Form { name, blocks: blocks.to_vec(), point, normal };
    vec![
        form("gnomon", &[[[-0.05, 0.0, -0.05], [0.05, 2.0, 0.05]]], [0.5, 0.0, -1.5], UP),
        form("wall", &[[[-300.0, 0.0, -0.2], [300.0, 4.0, 0.2]]], [2.0, 0.0, -3.0], UP),
        form(
            "slot",
            &[[[-2.0, 0.0, -300.0], [-1.0, 8.0, 300.0]], [[1.0, 0.0, -300.0], [2.0, 8.0, 300.0]]],
            [0.25, 0.0, 0.0],
            UP,
        ),
        form("overhang", &[[[-2.0, 2.5, -0.1], [2.0, 2.7, 1.2]]], [0.5, 1.2, 0.0], SOUTH),
        form(
            "court",
            &[
                [[-7.0, 0.0, -7.0], [-5.0, 6.0, 7.0]],
                [[5.0, 0.0, -7.0], [7.0, 6.0, 7.0]],
                [[-5.0, 0.0, -7.0], [5.0, 6.0, -5.0]],
                [[-5.0, 0.0, 5.0], [5.0, 6.0, 7.0]],
            ],
            [-1.0, 0.0, -2.0],
            UP,
        ),
    ]
}

impl Form {
    fn scene(&self) -> Scene {
        let boxes: Vec<Mesh> = self.blocks.iter().map(|&[low, high]| cuboid(low, high)).collect();
        scene_of(boxes)
    }

    fn is_lit(&self, towards: [f64; 3]) -> bool {
        let dot: f64 = (0..3).map(|a| self.normal[a] * towards[a]).sum();
        towards[1] > 0.0 && dot > 0.0 && !self.blocks.iter().any(|block| self.is_behind(block, towards))
    }

    /// Whether a block is between the point and the sun.
    fn is_behind(&self, [low, high]: &Block, towards: [f64; 3]) -> bool {
        let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
        for a in 0..3 {
            let [near, far] = [low[a], high[a]].map(|plane| (f64::from(plane) - self.point[a]) / towards[a]);
            enter = enter.max(near.min(far));
            leave = leave.min(near.max(far));
        }
        enter < leave
    }
}

/// The sun's direction at a time.
struct Sky<'a> {
    location: &'a Location,
    air: Option<&'a Atmosphere>,
}

impl Sky<'_> {
    fn towards(&self, time: f64) -> [f64; 3] {
        position(self.location, time, self.air).expect("a sun").towards()
    }
}

/// The spans in which a form's point is lit, from a look each `STEP` seconds and halvings between two that
/// differ.
fn expected(form: &Form, sky: &Sky<'_>, looks: &[(f64, [f64; 3])]) -> Vec<[f64; 2]> {
    let mut edges = Vec::new();
    let mut last = false;
    for pair in looks.windows(2) {
        let [(mut low, before), (mut high, after)] = [pair[0], pair[1]];
        let [was, is] = [before, after].map(|towards| form.is_lit(towards));
        if edges.is_empty() && was {
            edges.push(low);
        }
        if was != is {
            for _ in 0..20 {
                let middle = 0.5 * (low + high);
                if form.is_lit(sky.towards(middle)) == was { low = middle } else { high = middle }
            }
            edges.push(high);
        }
        last = is;
    }
    if last {
        edges.push(looks[looks.len() - 1].0);
    }
    edges.as_chunks::<2>().0.to_vec()
}

const STEP: usize = 20;

#[test]
fn hours_are_those_of_closed_forms_to_a_tenth_of_a_second() {
    let (mut ends, mut farthest) = (0, 0.0_f64);
    for latitude in ["0", "35.7", "52.5", "-33.9"] {
        for date in ["2026-03-20", "2026-06-21", "2026-12-21"] {
            let day: Day =
                format!("lat={latitude},lon=13.4,date={date},from=0,to=24").parse().expect("a day");
            let [from, to] = day.ends().expect("ends");
            let sky = Sky { location: &day.location, air: day.atmosphere.as_ref() };
            let looks: Vec<(f64, [f64; 3])> =
                (from..=to).step_by(STEP).map(|time| (time as f64, sky.towards(time as f64))).collect();
            let suns = Suns::new(&day.arcs().expect("arcs"));
            for form in forms() {
                let scene = form.scene();
                let tracer = Tracer::build(&scene, TraceOptions::default());
                let facing = Facing::Front(form.normal);
                let point = Receiver { p_world: form.point, facing, lift_world: 0.0 };
                let hours = suns.hours(&tracer, &[point], Watch::none()).expect("hours");
                let expected = expected(&form, &sky, &looks);
                let (name, found) = (form.name, hours.spans(0));
                assert_eq!(
                    found.len(),
                    expected.len(),
                    "{name} at {latitude}, {date}: {found:?} {expected:?}"
                );
                for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
                    let off = (found - expected).abs();
                    assert!(off < 0.1, "{name} at {latitude}, {date}: off by {off} s");
                    (ends, farthest) = (ends + 1, farthest.max(off));
                }
            }
        }
    }
    println!("{ends} ends of spans, the farthest off by {farthest:.4} s");
    assert!(ends > 100, "{ends}");
}
