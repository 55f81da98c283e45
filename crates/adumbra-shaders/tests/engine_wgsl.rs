//! The texts that `adumbra` gives an engine are valid WGSL before an engine's own, whatever its bindings, and
//! their names have the project's prefix.

use adumbra::gpu::{Bindings, LookUp, TexelFormat};
use adumbra::stream::{Resident, StreamOptions};
use adumbra_testing::vectors;
use naga::valid::{Capabilities, ValidationFlags, Validator};

/// An engine's fragment shader.
const ENGINE_WGSL: &str = "
@group(0) @binding(0) var<uniform> tint: vec4f;

@fragment
fn main(@builtin(position) pixel: vec4f, @location(0) p: vec3f, @location(1) normal: vec3f) -> @location(0) vec4f {
    let visibility = adumbra_visibility(p, normal) * adumbra_soft_visibility(p, normal, vec2u(pixel.xy));
    return visibility * tint;
}
";

/// Returns the names that a module declares.
fn names(module: &naga::Module) -> Vec<String> {
    let variables = module.global_variables.iter().map(|(_, variable)| variable.name.clone());
    let functions = module.functions.iter().map(|(_, function)| function.name.clone());
    let constants = module.constants.iter().map(|(_, constant)| constant.name.clone());
    let types = module.types.iter().map(|(_, of)| of.name.clone());
    let names: Vec<_> = variables.chain(functions).chain(constants).chain(types).flatten().collect();
    assert!(names.len() > 30, "{names:?}");
    names
}

#[test]
fn texts_for_engines_are_valid_and_have_the_prefix() {
    let file = adumbra::ShadowFile::read(vectors("valid/many_pages_depths.adumbra")).expect("a valid file");
    let texture = file.gpu().texture(&LookUp::default(), 4096).expect("a small file");
    let streamed = Resident::new(StreamOptions::default());
    for bindings in [Bindings::default(), Bindings { group: 0, first: 1 }, Bindings { group: 3, first: 9 }] {
        for text in [
            file.gpu().wgsl(bindings),
            texture.wgsl(TexelFormat::R32Uint, bindings),
            texture.wgsl(TexelFormat::Rgba8Unorm, bindings),
            streamed.wgsl(bindings),
        ] {
            let parsed = |text: &str| {
                naga::front::wgsl::parse_str(text)
                    .unwrap_or_else(|e| panic!("{bindings:?}: {}", e.emit_to_string(text)))
            };
            for name in names(&parsed(&text)) {
                assert!(name.to_ascii_lowercase().starts_with("adumbra"), "{name}");
            }
            let text = text + ENGINE_WGSL;
            let module = parsed(&text);
            let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
            if let Err(e) = validator.validate(&module) {
                panic!("{bindings:?}: {}", e.emit_to_string(&text));
            }
        }
    }
}
