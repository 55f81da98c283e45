//! `adumbra render`: a picture on the CPU.

use adumbra::camera::{Camera, Projection};
use adumbra::format::AnyFile;
use adumbra::picture::{self, Shadows};
use adumbra::scene::Bounds;
use adumbra::trace::{TraceOptions, Tracer};
use serde_json::json;

use super::lookup::{Asking, ignored_alpha, sun_of};
use super::{load_scene, print_json, with_threads};
use crate::args::Render;
use crate::exit::{Code, Failure, Outcome};
use crate::output::write_png;

pub(crate) fn run(args: &Render) -> Outcome {
    if !(args.fov > 0.0 && args.fov < 180.0) {
        return Err(Failure::Usage(format!("--fov {}: give degrees between 0 and 180", args.fov)));
    }
    let file = args.shadow_file.as_deref().map(AnyFile::read).transpose()?;
    let mut load = args.load.load_options()?;
    load.color_textures = true;
    load.ignore_alpha |= file.as_ref().is_some_and(ignored_alpha);
    let picture = with_threads(args.work.threads, || {
        let scene = load_scene(&args.scene, &load)?;
        let tracer = Tracer::build(&scene, TraceOptions { ignore_alpha: load.ignore_alpha });
        args.work
            .check_memory("the scene and its rays' trees", scene.memory_bytes() + tracer.memory_bytes())?;
        let [width, height] = args.size;
        let whole = Camera { width, height, ..looking_at(&scene.bounds(), args.fov) };
        let camera = Camera {
            eye: args.eye.unwrap_or(whole.eye),
            target: args.target.unwrap_or(whole.target),
            ..whole
        };
        if camera.eye == camera.target || !camera.eye.iter().chain(&camera.target).all(|c| c.is_finite()) {
            return Err(Failure::Usage(
                "--eye and --target must be finite and two different points".to_owned(),
            ));
        }
        let asking = Asking { bias: &args.bias, filter: args.filter, weights: args.weights.into() };
        let lookup = file.as_ref().map(|f| asking.lookup(f)).transpose()?;
        let shadows = match &lookup {
            Some(_) if args.truth => Shadows::Truth,
            Some(lookup) if args.diff => Shadows::Difference(&**lookup),
            Some(lookup) => Shadows::File(&**lookup),
            None => Shadows::Truth,
        };
        let sun = match &file {
            Some(file) => sun_of(file),
            None => args.sun.sun()?,
        };
        Ok(picture::draw(&scene, &tracer, &camera, sun.towards(), &shadows, args.antialias))
    })?;
    write_png(&args.output, &picture)?;
    if args.json {
        print_json(&json!({
            "output": args.output.display().to_string(),
            "width": picture.width,
            "height": picture.height,
            "difference_share": picture.difference_share,
        }));
    } else if let Some(share) = picture.difference_share {
        say!("{}: file and rays differ on {:.3} % of the samples", args.output.display(), 100.0 * share);
    } else {
        say!("{}: {} x {}", args.output.display(), picture.width, picture.height);
    }
    Ok(Code::Fine)
}

/// A camera that sees a whole box from above at an angle.
pub(super) fn looking_at(bounds: &Bounds, fov_degrees: f64) -> Camera {
    let mut center: [f64; 3] = std::array::from_fn(|a| 0.5 * (bounds.min[a] + bounds.max[a]));
    let extent: [f64; 3] = std::array::from_fn(|a| bounds.max[a] - bounds.min[a]);
    if extent[1] < extent[0].max(extent[2]) {
        // A ground with a few tall things.
        center[1] = 0.8 * bounds.min[1] + 0.2 * bounds.max[1];
    }
    let distance = 0.5 * bounds.diagonal() / (fov_degrees.to_radians() * 0.5).tan() * 0.7;
    // From the south-west, beside the default sun: shadows fall across the view.
    let direction = [-0.6, 0.5, 0.62];
    let eye = std::array::from_fn(|a| center[a] + direction[a] * distance);
    let projection = Projection::Perspective { fov_degrees };
    Camera { eye, target: center, projection, width: 1280, height: 720 }
}
