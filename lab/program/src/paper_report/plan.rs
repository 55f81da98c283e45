//! The commands that a report runs, section by section.

use std::path::{Path, PathBuf};

use adumbra_scene::GeneratedKind;

use super::step::CommandStep;
use crate::args::Report;

/// Generated scenes that are measured if no folder of scenes is given.
const MADE: &str = "city,primitives,landscape";
/// Scenes that a quick run uses from a folder of scenes, if they exist.
const WANTED: [&str; 2] = ["kaykit_city_21", "zdm2"];
/// The report's own folder of scenes.
const OWN: &str = "scenes";
pub(super) const SCENES: &str = "$SCENES";
pub(super) const TRUTH: &str = "$TRUTH";

/// Returns the commands of a section.
///
/// # Errors
/// Returns the reason if something that the section needs was not given.
pub(super) fn steps(section: &str, args: &Report) -> Result<Vec<CommandStep>, &'static str> {
    match section {
        "peers" if args.truth.is_none() => Err("needs --scenes and --truth"),
        "fast" if !args.full => Err("needs --full"),
        _ if args.full => Ok(full(section)),
        _ => Ok(quick(section, args)),
    }
}

/// Returns the commands of a full run: every benchmark at its defaults.
fn full(section: &str) -> Vec<CommandStep> {
    let bench = |words: &str| {
        CommandStep::laboratory(section, &format!("bench {words} --scenes {SCENES} -o data/{section}"))
    };
    match section {
        "bake" | "tree" | "hrsm" => vec![bench(section)],
        "verify" => vec![bench("verify"), bench("verify --volume --samples 300000")],
        "blur" => vec![CommandStep::laboratory(section, &format!("bench blur -o data/{section}"))],
        "shadows" => {
            let mut steps = vec![bench(&format!("shadows --truth {TRUTH}"))];
            steps.extend(beside_truth("1280x720", 9));
            steps
        }
        "ao" => {
            let mut steps = vec![bench(&format!("ao --truth {TRUTH}"))];
            steps.extend(occlusion_pictures("1280x720"));
            steps
        }
        "peers" => vec![bench(&format!("peers --truth {TRUTH}"))],
        _ => vec![bench("bake --suite fast")],
    }
}

/// Returns the commands of a quick run, at sizes that two cores measure in minutes.
///
/// Scenes are generated if no folder of them is given.
fn quick(section: &str, args: &Report) -> Vec<CommandStep> {
    let [width, height] = args.size;
    let size = format!("{width}x{height}");
    let found = |name: &&str| args.scenes.as_ref().is_some_and(|s| s.join(format!("{name}.glb")).exists());
    let real: Vec<&str> = WANTED.into_iter().filter(|name| found(name)).collect();
    let (folder, names) = if real.is_empty() {
        (OWN, MADE.split(',').map(|n| format!("{n}.glb")).collect::<Vec<_>>().join(","))
    } else {
        (SCENES, real.iter().map(|n| format!("{n}.glb")).collect::<Vec<_>>().join(","))
    };
    let given = args.scenes.as_ref().map_or(OWN, |_| SCENES);
    let one = |words: String| CommandStep::laboratory(section, &format!("{words} -o data/{section}"));
    let has = |file: &str| args.scenes.as_ref().is_some_and(|s| s.join(file).exists());
    match section {
        "bake" => vec![one(format!(
            "bench bake --scenes {folder} --names {names} --resolutions 1024,2048,4096 --variant-resolution 4096"
        ))],
        "verify" => vec![one(format!(
            "bench verify --scenes {folder} --names {names} --resolution 4096 --samples 100000"
        ))],
        "tree" => [
            ("builders", "builders --depths 8,9 --runs 3"),
            ("reductions", "reductions --depths 7,8,9,10 --runs 3"),
            ("others", "frames,options,filters --runs 1"),
        ]
        .map(|(name, only)| {
            let scenes = "--names primitives,landscape --samples 20000";
            CommandStep::laboratory(
                name,
                &format!("bench tree --scenes {OWN} {scenes} --only {only} -o data/tree"),
            )
        })
        .into(),
        "hrsm" => {
            // The Dragon has 2.4 million triangles, so there is only time for one START.
            let (models, starts) = if has("dragon_202k.ply") {
                ("dragon,spheres", "1024")
            } else {
                ("ball,spheres", "1024,2048")
            };
            let mut steps = vec![one(format!(
                "bench hrsm --scenes {given} --only {models},wires --starts {starts} --frames 2 --size {size}"
            ))];
            steps.extend(hybrid_pictures(&size));
            steps
        }
        "blur" => {
            vec![one(format!("bench blur --samples 8,16,32,64 --runs 3 --size {}x{}", width / 2, height / 2))]
        }
        "shadows" => beside_truth(&size, 3),
        "ao" => {
            let scene = if has("dragon_202k.ply") { "dragon" } else { "cornell" };
            let truth = if args.truth.is_some() { format!(" --truth {TRUTH}") } else { String::new() };
            let mut steps = vec![one(format!(
                "bench ao --scenes {given} --only {scene}{truth} --frames 3 --rays 64 --size {size}"
            ))];
            steps.extend(occlusion_pictures(&size));
            steps
        }
        _ => vec![one(format!(
            "bench peers --scenes {SCENES} --truth {TRUTH} --resolution 8192 --cube-resolution 1024"
        ))],
    }
}

/// Scenes generated for pictures, and for users without a folder of scenes.
const MADE_FOR_PICTURES: [(GeneratedKind, &str); 4] = [
    (GeneratedKind::City, "city"),
    (GeneratedKind::Primitives, "primitives"),
    (GeneratedKind::Landscape, "landscape"),
    (GeneratedKind::Cornell, "cornell"),
];

/// Returns the generated scenes and their paths in the report's folder.
pub(super) fn made_scenes() -> impl Iterator<Item = (GeneratedKind, PathBuf)> {
    MADE_FOR_PICTURES.into_iter().map(|(kind, name)| (kind, Path::new(OWN).join(format!("{name}.glb"))))
}

/// Returns the commands that generate these scenes.
pub(super) fn made_commands() -> impl Iterator<Item = String> {
    MADE_FOR_PICTURES.into_iter().map(|(_, name)| format!("adumbra generate {name} -o {OWN}/{name}.glb"))
}

/// Returns comparisons on generated scenes: from the street, from afar, along a path, and a moving ball.
fn beside_truth(size: &str, frames: u32) -> Vec<CommandStep> {
    let compare = |name: &str, scene: &str, rest: &str| {
        let words = format!(
            "compare {OWN}/{scene}.glb {rest} --frames {frames} --size {size} -o data/shadows/{name}"
        );
        CommandStep::laboratory(name, &words)
    };
    let shadow = |names: &[&str]| names.iter().map(|n| format!(" --shadow {n}")).collect::<String>();
    let street = [
        "voxel:filter=5",
        "sm",
        "pcf",
        "csm:filter=5",
        "pcss",
        "vsm",
        "csm-vsm",
        "blur",
        "blur-dilate",
        "blur-bilateral",
    ];
    let far = ["csm:filter=1", "csm-vsm", "csm-evsm", "voxel:filter=5"];
    let path = ["voxel-cubes:filter=3", "voxel-cubes:filter=5", "csm"];
    vec![
        compare("street", "city", &format!("--camera street --resolution 8192{}", shadow(&street))),
        compare("far", "city", &format!("--camera overview --resolution 8192{}", shadow(&far))),
        compare(
            "path",
            "landscape",
            &format!("--path fly --path-frames 12 --cube-resolution 1024{}", shadow(&path)),
        ),
        CommandStep::product(
            "ball",
            &format!("bake {OWN}/city.glb --resolution 8192 --progress none -o data/shadows/city.adumbra"),
        ),
        CommandStep::product(
            "ball",
            &format!(
                "render {OWN}/city.glb --shadow-file data/shadows/city.adumbra --move sphere --frames 4 --antialias 1 \
                 --size {size} -o data/shadows/ball.png"
            ),
        ),
    ]
}

/// Returns a comparison at the paper's pairs of resolutions: a ring over a floor, seen from near its shadow.
fn hybrid_pictures(size: &str) -> Vec<CommandStep> {
    let names = [
        "sm:size=512",
        "sm:size=1024",
        "sm:size=2048",
        "hrsm:1024-512:filter=1",
        "hrsm:2048-1024:filter=1",
        "hrsm:4096-2048:filter=1",
        "hrsm:2048-512:filter=1",
        "hrsm:4096-512:filter=1",
        "hrsm:2048-1024:test=paper:filter=1",
    ];
    let shadows: String = names.iter().map(|n| format!(" --shadow {n}")).collect();
    let words = format!(
        "compare {OWN}/primitives.glb --eye=-12.5,3.6,-4.2 --target=-8.4,0.6,0 --fov 40 --frames 1 --size {size}{shadows} \
         -o data/hrsm/pictures"
    );
    vec![CommandStep::product("pictures", &words)]
}

/// Returns renderings by every estimator of the room with two blocks.
fn occlusion_pictures(size: &str) -> Vec<CommandStep> {
    ["truth", "ssao", "hbao", "alchemy", "issao", "issao:attenuation=off", "issao:filter=none", "gtao"]
        .map(|ao| {
            let file = ao.replace([':', '='], "-");
            let rays = if ao == "truth" { ":rays=64" } else { "" };
            let words = format!(
                "render {OWN}/cornell.glb --ao {ao}:radius=1{rays} --layer ao --eye -0.6,3.4,6 --target -0.2,1.9,0 --fov 50 \
                 --antialias 1 --size {size} -o data/ao/{file}.png"
            );
            CommandStep::product(ao, &words)
        })
        .into()
}
