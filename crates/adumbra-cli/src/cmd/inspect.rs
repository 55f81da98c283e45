//! `adumbra inspect`: what a scene contains.

use adumbra::{Bounds, LightExtent, Sun};
use adumbra_program::exit::{Code, Outcome};
use adumbra_program::glance::{AtAGlance, look, warn_of_large_voxels};
use adumbra_program::output::print_json;
use adumbra_program::scene::{Omitted, load_scene_within, omitted};
use adumbra_program::sun::{SunOrigin, sun_of_scene_with_warnings};
use adumbra_program::threads::with_threads;
use adumbra_program::{mirrors, say};
use adumbra_scene::{AlphaMode, Counts, FileSun, Scene, topology};
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Inspect;

/// The properties of a scene.
#[derive(Serialize, JsonSchema)]
pub(super) struct Inspected {
    /// The scene's file.
    scene: String,
    /// Number of triangles of the meshes. Each mesh counts once.
    triangles: u64,
    /// Number of triangles of the instances. A mesh counts as often as it is placed.
    instanced_triangles: u64,
    /// Number of meshes.
    meshes: usize,
    /// Number of instances.
    instances: usize,
    /// Number of animated instances. No other field counts them.
    skipped_movers: u64,
    /// Number of materials.
    materials: usize,
    /// Number of materials with an alpha mask.
    masked_materials: usize,
    /// Number of blended materials.
    blended_materials: u64,
    /// Number of triangles whose material is blended.
    blended_triangles: u64,
    /// Number of triangles without area.
    degenerate_triangles: u64,
    /// Number of polygons of OBJ and PLY files that were cut into fans, which may cover too much or too
    /// little.
    untriangulated_polygons: u64,
    /// Bounding box of the scene.
    #[schemars(with = "mirrors::Bounds")]
    bounds: Bounds,
    /// Share of the instanced triangles that are in closed components.
    closed_share: f64,
    /// Share of the instanced triangles that bound solids.
    solid_share: f64,
    /// Suggested resolution of a bake: voxels of about 5 cm, if the scene is in metres.
    suggested_resolution: u32,
    /// Unit vector towards the sun that the scene is baked for unless `--sun` is given.
    sun: [f64; 3],
    /// Where that sun comes from.
    sun_origin: SunOrigin,
    /// The directional lights of the file.
    lights: Vec<Light>,
    /// What the file states and the loader has read, before anything was dropped.
    read: Read,
    /// What the file holds and the loader left out, each kind once.
    omissions: Vec<Omitted>,
    /// Warnings of the loader.
    warnings: Vec<String>,
    /// What a person would see of the scene under that sun.
    glance: AtAGlance,
}

/// A directional light of a scene's file.
#[derive(Serialize, JsonSchema)]
struct Light {
    /// The name of its node.
    name: String,
    /// Unit vector towards it.
    towards: [f64; 3],
}

impl Light {
    fn of(light: &FileSun) -> Self {
        Self { name: light.name.clone(), towards: light.unit_towards() }
    }
}

/// What was read from a scene's file.
#[derive(Serialize, JsonSchema)]
struct Read {
    /// Meshes of a glTF file, objects and groups of an OBJ file, 1 for a PLY file.
    meshes: u64,
    /// Nodes of a glTF file. 0 for other formats.
    nodes: u64,
    /// Faces with three or more corners.
    faces: u64,
}

impl Read {
    fn of(counts: &Counts) -> Self {
        Self { meshes: counts.meshes, nodes: counts.nodes, faces: counts.faces }
    }
}

pub(crate) fn run(args: &Inspect) -> Outcome {
    with_threads(args.run.threads, || inspect(args))?
}

fn inspect(args: &Inspect) -> Outcome {
    let limit = args.run.memory_limit();
    let scene = load_scene_within(limit, &args.scene, &args.load.load_options()?)?;
    let most = scene.meshes.iter().map(topology::working_bytes).max().unwrap_or_default();
    args.run.check_memory("the scene's topology", scene.memory_bytes(), scene.memory_bytes() + most)?;
    let bounds = scene.bounds();
    let (closed, solid) = closed_shares(&scene);
    let masked = scene.materials.iter().filter(|m| matches!(m.alpha, AlphaMode::Mask { .. })).count();
    let triangles = scene.stored_triangles();
    let instanced = scene.instanced_triangles();
    let sun = sun_of_scene_with_warnings(&scene, &args.scene)?;
    let glance = look(&scene, &args.scene, sun.sun, args.load.ignore_alpha);
    let suggested = suggested_resolution(&scene, &sun.sun);
    let mut extent = LightExtent::empty(&sun.sun);
    extent.add_box(&bounds);
    warn_of_large_voxels(&args.scene, &glance, extent.longest_side() / f64::from(suggested));
    limit.check_peak("the scene's topology")?;
    if args.run.json {
        print_json(&Inspected {
            scene: args.scene.display().to_string(),
            triangles,
            instanced_triangles: instanced,
            meshes: scene.meshes.len(),
            instances: scene.instances.len(),
            skipped_movers: scene.notes.skipped_movers,
            materials: scene.materials.len(),
            masked_materials: masked,
            blended_materials: scene.notes.blended_materials,
            blended_triangles: scene.notes.blended_triangles,
            degenerate_triangles: scene.notes.degenerate_triangles,
            untriangulated_polygons: scene.notes.untriangulated_polygons,
            bounds,
            closed_share: closed,
            solid_share: solid,
            suggested_resolution: suggested,
            sun: sun.sun.towards(),
            sun_origin: sun.origin,
            lights: scene.suns.iter().map(Light::of).collect(),
            read: Read::of(&scene.notes.read),
            omissions: omitted(&scene),
            warnings: scene.notes.warnings,
            glance: AtAGlance::of(&glance),
        })?;
    } else {
        let read = &scene.notes.read;
        say!("{}", args.scene.display());
        say!("  read                 {} meshes, {} nodes, {} faces", read.meshes, read.nodes, read.faces);
        for omission in &scene.notes.omissions {
            say!("  left out             {omission}");
        }
        say!("  triangles            {triangles} stored, {instanced} with instances");
        say!("  meshes, instances    {}, {}", scene.meshes.len(), scene.instances.len());
        say!("  bounds               {:?} to {:?}", bounds.min, bounds.max);
        say!(
            "  closed               {:.1} % of triangles, {:.1} % bound solids",
            100.0 * closed,
            100.0 * solid
        );
        say!("  materials            {}, {masked} masked", scene.materials.len());
        say!("  degenerate triangles {}", scene.notes.degenerate_triangles);
        for light in &scene.suns {
            let [x, y, z] = light.unit_towards();
            say!("  directional light    {:?}, towards {x:.4},{y:.4},{z:.4}", light.name);
        }
        say!("  {}", AtAGlance::of(&glance));
        say!("  suggested resolution {suggested}, for the {sun}");
    }
    Ok(Code::Fine)
}

/// Returns the shares of the instanced triangles that are in closed components and that bound solids.
fn closed_shares(scene: &Scene) -> (f64, f64) {
    let mut placed = vec![0_u64; scene.meshes.len()];
    for instance in &scene.instances {
        placed[instance.mesh as usize] += 1;
    }
    let (mut all, mut closed, mut solid) = (0, 0, 0);
    for (mesh, count) in scene.meshes.iter().zip(placed) {
        let shape = topology::analyse(mesh, &scene.materials);
        all += count * mesh.triangles.len() as u64;
        for component in &shape.components {
            let triangles = count * u64::from(component.triangles);
            closed += if component.closed { triangles } else { 0 };
            solid += if component.solid { triangles } else { 0 };
        }
    }
    let share = |part: u64| if all == 0 { 0.0 } else { part as f64 / all as f64 };
    (share(closed), share(solid))
}

/// Edge of a voxel for the suggested resolution, world units: 5 cm if they are metres. The resolution is
/// limited to what bakes in minutes.
const SUGGESTED_VOXEL: f64 = 0.05;

fn suggested_resolution(scene: &Scene, sun: &Sun) -> u32 {
    let mut extent = LightExtent::empty(sun);
    extent.add_box(&scene.bounds());
    let texels = (extent.longest_side() / SUGGESTED_VOXEL).clamp(2048.0, 32768.0);
    (texels as u32).next_power_of_two()
}
