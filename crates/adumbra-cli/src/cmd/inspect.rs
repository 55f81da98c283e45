//! `adumbra inspect`: what a scene holds.

use adumbra::light::{LightExtent, Sun};
use adumbra::scene::{AlphaMode, Scene, topology};
use serde_json::json;

use super::{load_scene, print_json};
use crate::args::Inspect;
use crate::exit::{Code, Outcome};

pub(crate) fn run(args: &Inspect) -> Outcome {
    let scene = load_scene(&args.scene, &args.load.load_options(args.max_memory)?)?;
    let bounds = scene.bounds();
    let (closed, solid) = closed_shares(&scene);
    let masked = scene.materials.iter().filter(|m| matches!(m.alpha, AlphaMode::Mask { .. })).count();
    let triangles = scene.stored_triangles();
    let instanced = scene.instanced_triangles();
    let suggested = suggested_resolution(&scene)?;
    if args.json {
        print_json(&json!({
            "scene": args.scene.display().to_string(),
            "triangles": triangles,
            "instanced_triangles": instanced,
            "meshes": scene.meshes.len(),
            "instances": scene.instances.len(),
            "movers_left_out": scene.notes.movers_left_out,
            "materials": scene.materials.len(),
            "masked_materials": masked,
            "blended_materials": scene.notes.blended_materials,
            "blended_triangles": scene.notes.blended_triangles,
            "degenerate_triangles": scene.notes.degenerate_triangles,
            "untriangulated_polygons": scene.notes.untriangulated_polygons,
            "bounds": bounds,
            "closed_share": closed,
            "solid_share": solid,
            "suggested_resolution": suggested,
            "warnings": scene.notes.warnings,
        }));
    } else {
        say!("{}", args.scene.display());
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
        say!("  suggested resolution {suggested}");
    }
    Ok(Code::Fine)
}

/// Shares of the instanced triangles that lie in closed components and that bound solids.
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

/// Voxels of about 5 cm in a scene of metres, within what bakes in minutes.
const SUGGESTED_VOXEL: f64 = 0.05;

fn suggested_resolution(scene: &Scene) -> Result<u32, adumbra::Error> {
    let mut extent = LightExtent::empty(&Sun::from_direction([0.5, 0.8, 0.35])?);
    extent.add_box(&scene.bounds());
    let texels = (extent.longest_side() / SUGGESTED_VOXEL).clamp(2048.0, 32768.0);
    Ok((texels as u32).next_power_of_two())
}
