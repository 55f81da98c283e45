//! A custom material receives baked shadows: by `apply_pbr_lighting`, or by looking up the visibility itself.

mod common;

use bevy::asset::{Asset, uuid_handle};
use bevy::pbr::{ExtendedMaterial, MaterialExtension};
use bevy::prelude::*;
use bevy::reflect::TypePath;
use bevy::render::render_resource::AsBindGroup;
use bevy::shader::ShaderRef;
use bevy_adumbra::prelude::*;

const SHADER: Handle<Shader> = uuid_handle!("7a1e7a0e-6a3f-4c02-9d5c-0d2f6f2f5a51");

/// Stripes where the sun shines. The extension is lit like any PBR material, so it is shadowed without extra
/// code. `adumbra::look_up` also gives it the place of the shadow.
const WGSL: &str = "
#import bevy_pbr::{
    forward_io::{VertexOutput, FragmentOutput},
    mesh_view_bindings::lights,
    pbr_fragment::pbr_input_from_standard_material,
    pbr_functions::{apply_pbr_lighting, main_pass_post_lighting_processing},
}
#import adumbra::look_up::sun_visibility

@fragment
fn fragment(in: VertexOutput, @builtin(front_facing) is_front: bool) -> FragmentOutput {
    var pbr_input = pbr_input_from_standard_material(in, is_front);
    let towards_sun = lights.directional_lights[0].direction_to_light;
    let visibility = sun_visibility(towards_sun, in.world_position.xyz, in.world_normal, in.position.xy);
    let stripe = step(0.5, fract(0.25 * (in.world_position.x + in.world_position.z)));
    pbr_input.material.base_color = mix(vec4(0.25, 0.3, 0.5, 1.0), vec4(0.9, 0.8, 0.5 + 0.3 * stripe, 1.0), visibility);
    var out: FragmentOutput;
    out.color = main_pass_post_lighting_processing(pbr_input, apply_pbr_lighting(pbr_input));
    return out;
}
";

#[derive(Asset, TypePath, AsBindGroup, Clone, Default)]
struct Striped {}

impl MaterialExtension for Striped {
    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }
}

type StripedMaterial = ExtendedMaterial<StandardMaterial, Striped>;

fn main() {
    let mut app = common::app();
    app.add_plugins(MaterialPlugin::<StripedMaterial>::default())
        .add_systems(Startup, setup)
        .add_systems(Update, give_materials);
    let shader = Shader::from_wgsl(WGSL, "examples/own_material.wgsl");
    app.world_mut().resource_mut::<Assets<Shader>>().insert(&SHADER, shader).expect("a new shader");
    app.run();
}

fn setup(mut commands: Commands, assets: Res<AssetServer>) {
    commands.spawn((
        DirectionalLight { shadow_maps_enabled: true, ..default() },
        BakedShadow::new(assets.load("city.adumbra")),
    ));
    commands.spawn((WorldAssetRoot(assets.load("city.glb#Scene0")), ShadowStatic));
    commands.spawn(common::camera());
}

fn give_materials(
    mut commands: Commands,
    new: Query<Entity, Added<MeshMaterial3d<StandardMaterial>>>,
    mut materials: ResMut<Assets<StripedMaterial>>,
    mut one: Local<Option<Handle<StripedMaterial>>>,
) {
    for entity in &new {
        let material = one.get_or_insert_with(|| materials.add(StripedMaterial::default())).clone();
        commands.entity(entity).remove::<MeshMaterial3d<StandardMaterial>>().insert(MeshMaterial3d(material));
    }
}
