//! Copies the meshes of a bake out of Bevy's assets.

use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

use adumbra_scene::{AlphaMode, Instance, Material, Mesh, Pixels, Scene, Texture, Wrap};
use bevy::asset::{AssetId, AssetServer, Assets, LoadState, UntypedAssetId};
use bevy::camera::visibility::VisibilityRange;
use bevy::color::Alpha;
use bevy::ecs::prelude::{Entity, Res};
use bevy::ecs::system::SystemParam;
use bevy::image::{Image, ImageAddressMode, ImageFilterMode, ImageSampler, ImageSamplerDescriptor};
use bevy::log::warn;
use bevy::math::Affine2;
use bevy::mesh::{
    Indices, Mesh as BevyMesh, Mesh3d, MeshAccessError, PrimitiveTopology, UvChannel, VertexAttributeValues,
};
use bevy::pbr::{MeshMaterial3d, StandardMaterial};
use bevy::prelude::{AlphaMode as BevyAlphaMode, GlobalTransform};
use bevy::render::render_resource::TextureFormat;

use super::progress::BakeError;
use super::versions::AssetVersions;

/// A mesh with its transform and material.
#[derive(Clone, Copy)]
pub(super) struct Placed<'w> {
    mesh: AssetId<BevyMesh>,
    transform: &'w GlobalTransform,
    material: Option<AssetId<StandardMaterial>>,
    casts: bool,
}

type Item<'w> = (
    Entity,
    &'w Mesh3d,
    &'w GlobalTransform,
    Option<&'w MeshMaterial3d<StandardMaterial>>,
    bool,
    Option<&'w VisibilityRange>,
);

impl<'w> From<Item<'w>> for Placed<'w> {
    fn from((_, mesh, transform, material, no_caster, range): Item<'w>) -> Self {
        // Only the finest level of detail casts.
        let is_finest = range.is_none_or(|range| range.start_margin.start <= 0.0);
        let casts = !no_caster && is_finest;
        Self { mesh: mesh.id(), transform, material: material.map(|m| m.id()), casts }
    }
}

impl Placed<'_> {
    /// Returns a hash of everything that affects the mesh's shadow.
    pub(super) fn key(&self, materials: &Assets<StandardMaterial>, versions: &mut AssetVersions) -> u64 {
        let mut hasher = DefaultHasher::new();
        let columns = self.transform.affine().to_cols_array().map(f32::to_bits);
        (self.mesh, columns, self.casts).hash(&mut hasher);
        versions.of(self.mesh).hash(&mut hasher);
        if let Some(id) = self.material {
            // Track the material, but do not hash its version: only the properties below affect a bake.
            versions.of(id);
            let material = materials.get(id);
            material.map(|material| material.specular_transmission > 0.0).hash(&mut hasher);
            if let Some(material) = material.filter(|material| material.alpha_mode != BevyAlphaMode::Opaque) {
                let cutoff = match material.alpha_mode {
                    BevyAlphaMode::Mask(cutoff) => cutoff.to_bits(),
                    _ => u32::MAX,
                };
                (cutoff, material.base_color.alpha().to_bits()).hash(&mut hasher);
                if let Some(image) = &material.base_color_texture {
                    (image.id(), versions.of(image.id())).hash(&mut hasher);
                    let uv_columns = material.uv_transform.to_cols_array().map(f32::to_bits);
                    (uv_columns, material.base_color_channel == UvChannel::Uv1).hash(&mut hasher);
                }
            }
        }
        hasher.finish()
    }
}

/// The assets that a bake reads.
#[derive(SystemParam)]
pub(crate) struct SceneAssets<'w> {
    meshes: Res<'w, Assets<BevyMesh>>,
    materials: Res<'w, Assets<StandardMaterial>>,
    images: Res<'w, Assets<Image>>,
    server: Option<Res<'w, AssetServer>>,
}

impl SceneAssets<'_> {
    /// Whether an asset of this mesh is being loaded.
    fn is_loading(&self, placed: &Placed) -> bool {
        let loads = |id: UntypedAssetId| {
            self.server.as_ref().is_none_or(|server| {
                matches!(server.get_load_state(id), Some(LoadState::NotLoaded | LoadState::Loading))
            })
        };
        let material = placed.material.and_then(|id| self.materials.get(id));
        let with_holes = material.filter(|material| material.alpha_mode != BevyAlphaMode::Opaque);
        let image = with_holes.and_then(|material| material.base_color_texture.as_ref());
        (self.meshes.get(placed.mesh).is_none() && loads(placed.mesh.untyped()))
            || placed.material.is_some_and(|id| material.is_none() && loads(id.untyped()))
            || image.is_some_and(|image| self.images.get(image).is_none() && loads(image.id().untyped()))
    }
}

/// Copies the meshes with their materials. Returns `None` while some are being loaded. Meshes that are
/// neither loaded nor loading are left out; such materials and images count as opaque.
///
/// # Errors
/// Returns an error if a mesh cannot be read or is not finite, or if no mesh has triangles.
pub(super) fn gather<'w>(
    placed: impl Iterator<Item = Placed<'w>> + Clone,
    assets: &SceneAssets,
) -> Result<Option<Scene>, BakeError> {
    // Check all meshes before copying any.
    if placed.clone().any(|placed| assets.is_loading(&placed)) {
        return Ok(None);
    }
    let mut scene = Scene::default();
    // Keyed by mesh and material, because a mesh of the scene stores the material of each triangle.
    let mut known: HashMap<_, Option<u32>> = HashMap::new();
    let mut known_materials: HashMap<_, u32> = HashMap::new();
    let mut left_out = 0;
    for p in placed {
        let index = match known.get(&(p.mesh, p.material)) {
            Some(index) => *index,
            None => {
                let Some(mesh) = assets.meshes.get(p.mesh) else {
                    left_out += 1;
                    continue;
                };
                let material = match known_materials.get(&p.material) {
                    Some(material) => *material,
                    None => {
                        let new = material(p.material, assets, &mut scene.textures);
                        scene.materials.push(new);
                        known_materials.insert(p.material, scene.materials.len() as u32 - 1);
                        scene.materials.len() as u32 - 1
                    }
                };
                let name = scene.meshes.len().to_string();
                let look = p.material.and_then(|id| assets.materials.get(id));
                let index = copy(mesh, name, look, material)?.map(|mesh| {
                    scene.meshes.push(mesh);
                    scene.meshes.len() as u32 - 1
                });
                known.insert((p.mesh, p.material), index);
                index
            }
        };
        let Some(mesh) = index else { continue };
        let m = p.transform.affine();
        let row = |r: usize| {
            [m.matrix3.x_axis[r], m.matrix3.y_axis[r], m.matrix3.z_axis[r], m.translation[r]].map(f64::from)
        };
        let name = String::new();
        scene.instances.push(Instance { name, mesh, world_from_mesh: [0, 1, 2].map(row), casts: p.casts });
    }
    if left_out > 0 {
        warn!(
            "{left_out} meshes below a ShadowStatic are not in the bake, because their assets are not there"
        );
    }
    if scene.instances.is_empty() {
        return Err(BakeError::NoTriangles);
    }
    Ok(Some(scene))
}

/// Copies a mesh with the texture coordinates that its material uses. The material is the scene's material
/// `index`. Returns `None` if the mesh has no triangles.
fn copy(
    mesh: &BevyMesh,
    name: String,
    material: Option<&StandardMaterial>,
    index: u32,
) -> Result<Option<Mesh>, BakeError> {
    let is_strip = match mesh.primitive_topology() {
        PrimitiveTopology::TriangleList => false,
        PrimitiveTopology::TriangleStrip => true,
        _ => return Ok(None),
    };
    let no_access = |error: MeshAccessError| BakeError::Unreadable(error.into());
    let positions = match mesh.try_attribute_option(BevyMesh::ATTRIBUTE_POSITION).map_err(no_access)? {
        Some(VertexAttributeValues::Float32x3(positions)) => positions.clone(),
        _ => return Ok(None),
    };
    if positions.iter().flatten().any(|c| !c.is_finite()) {
        return Err(BakeError::NotFinite);
    }
    let channel = match material.map(|material| &material.base_color_channel) {
        Some(UvChannel::Uv1) => BevyMesh::ATTRIBUTE_UV_1,
        _ => BevyMesh::ATTRIBUTE_UV_0,
    };
    let uv_transform = material.map_or(Affine2::IDENTITY, |material| material.uv_transform);
    let uvs = match mesh.try_attribute_option(channel).map_err(no_access)? {
        Some(VertexAttributeValues::Float32x2(uvs)) if uvs.len() == positions.len() => {
            uvs.iter().map(|&uv| uv_transform.transform_point2(uv.into()).into()).collect()
        }
        _ => Vec::new(),
    };
    let indices: Vec<u32> = match mesh.try_indices_option().map_err(no_access)? {
        // The largest index restarts a strip, as on the GPU.
        Some(Indices::U16(indices)) => {
            indices.iter().map(|&i| if is_strip && i == u16::MAX { u32::MAX } else { i.into() }).collect()
        }
        Some(Indices::U32(indices)) => indices.clone(),
        None => (0..positions.len() as u32).collect(),
    };
    let has_area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|i| positions.get(i as usize).map(|p| p.map(f64::from)));
        let (Some(a), Some(b), Some(c)) = (a, b, c) else { return false };
        let [u, v] = [b, c].map(|p| [0, 1, 2].map(|axis| p[axis] - a[axis]));
        [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]] != [0.0; 3]
    };
    let all = if is_strip { of_strip(&indices) } else { indices.as_chunks().0.to_vec() };
    let triangles: Vec<[u32; 3]> = all.into_iter().filter(has_area).collect();
    if triangles.is_empty() {
        return Ok(None);
    }
    let triangle_materials = vec![index; triangles.len()];
    Ok(Some(Mesh { name, positions, uvs, colors: Vec::new(), triangles, triangle_materials }))
}

/// Returns the triangles of strips. Every second triangle of a strip is flipped.
fn of_strip(indices: &[u32]) -> Vec<[u32; 3]> {
    let strips = indices.split(|&i| i == u32::MAX);
    let triangles = strips.flat_map(|strip| strip.array_windows().enumerate());
    triangles.map(|(n, &[a, b, c])| if n % 2 == 0 { [a, b, c] } else { [b, a, c] }).collect()
}

/// Returns the properties of a material that affect shadows, and adds its texture if it has holes.
fn material(
    id: Option<AssetId<StandardMaterial>>,
    assets: &SceneAssets,
    textures: &mut Vec<Texture>,
) -> Material {
    let mut new = Material::opaque("", [1.0; 4]);
    // Materials of other types are opaque.
    let Some(material) = id.and_then(|id| assets.materials.get(id)) else { return new };
    new.transmissivity = material.specular_transmission.clamp(0.0, 1.0);
    let cutoff = match material.alpha_mode {
        BevyAlphaMode::Mask(cutoff) => cutoff,
        BevyAlphaMode::Opaque => return new,
        _ => {
            new.blended = true;
            0.5
        }
    };
    new.alpha = AlphaMode::Mask { cutoff };
    new.base_color[3] = material.base_color.alpha();
    let image = material.base_color_texture.as_ref().and_then(|image| assets.images.get(image));
    new.texture = image.and_then(texture).map(|texture| {
        textures.push(texture);
        textures.len() as u32 - 1
    });
    new
}

/// Returns an image's alpha; `None` if it has none that can be read, which counts as opaque.
fn texture(image: &Image) -> Option<Texture> {
    let formats = [
        TextureFormat::Rgba8Unorm,
        TextureFormat::Rgba8UnormSrgb,
        TextureFormat::Bgra8Unorm,
        TextureFormat::Bgra8UnormSrgb,
    ];
    let data = image.data.as_ref().filter(|_| formats.contains(&image.texture_descriptor.format))?;
    let (width, height) = (image.width(), image.height());
    let texels = width as usize * height as usize;
    let alphas: Vec<u8> = data.as_chunks::<4>().0.iter().take(texels).map(|texel| texel[3]).collect();
    if alphas.len() < texels.max(1) {
        return None;
    }
    let sampler = match &image.sampler {
        ImageSampler::Descriptor(sampler) => sampler.clone(),
        ImageSampler::Default => ImageSamplerDescriptor::default(),
    };
    let wrap = |mode| match mode {
        ImageAddressMode::Repeat => Wrap::Repeat,
        ImageAddressMode::MirrorRepeat => Wrap::Mirror,
        _ => Wrap::Clamp,
    };
    Some(Texture {
        name: String::new(),
        width,
        height,
        pixels: Pixels::Alpha(alphas),
        wrap: [wrap(sampler.address_mode_u), wrap(sampler.address_mode_v)],
        nearest: matches!(sampler.mag_filter, ImageFilterMode::Nearest),
    })
}

#[cfg(test)]
mod tests {
    use bevy::color::Color;
    use bevy::ecs::prelude::World;
    use bevy::ecs::system::RunSystemOnce;
    use bevy::math::Vec2;
    use bevy::math::primitives::Plane3d;

    use super::*;

    #[test]
    fn strips_are_triangles_that_all_face_one_way() {
        let strip = [0, 1, 2, 3, u32::MAX, 7, 8, 9, u32::MAX];
        assert_eq!(of_strip(&strip), [[0, 1, 2], [2, 1, 3], [7, 8, 9]]);
    }

    /// Returns the gathered scene of a plane with this material.
    fn plane_of(material: StandardMaterial) -> Scene {
        let mut world = World::new();
        world.init_resource::<Assets<BevyMesh>>();
        world.init_resource::<Assets<StandardMaterial>>();
        world.init_resource::<Assets<Image>>();
        let plane: BevyMesh = Plane3d::default().into();
        let Some(VertexAttributeValues::Float32x2(uvs)) = plane.attribute(BevyMesh::ATTRIBUTE_UV_0) else {
            panic!("a plane has texture coordinates")
        };
        let second: Vec<_> = uvs.iter().map(|[u, v]| [u + 1.0, v + 2.0]).collect();
        let plane = plane.with_inserted_attribute(BevyMesh::ATTRIBUTE_UV_1, second);
        let mesh = Mesh3d(world.resource_mut::<Assets<BevyMesh>>().add(plane));
        let material = MeshMaterial3d(world.resource_mut::<Assets<StandardMaterial>>().add(material));
        let of_plane = move |assets: SceneAssets| {
            let at = GlobalTransform::default();
            let placed = Placed::from((Entity::PLACEHOLDER, &mesh, &at, Some(&material), false, None));
            gather(std::iter::once(placed), &assets).unwrap().unwrap()
        };
        world.run_system_once(of_plane).unwrap()
    }

    #[test]
    fn uvs_follow_the_material_transform_and_channel() {
        let most = |material: StandardMaterial| {
            let scene = plane_of(StandardMaterial { alpha_mode: BevyAlphaMode::Mask(0.5), ..material });
            scene.meshes[0].uvs.iter().fold([0.0; 2], |most: [f32; 2], uv| [0, 1].map(|i| most[i].max(uv[i])))
        };
        assert_eq!(most(StandardMaterial::default()), [1.0, 1.0]);
        let uv_transform = Affine2::from_scale(Vec2::new(10.0, 3.0));
        assert_eq!(most(StandardMaterial { uv_transform, ..Default::default() }), [10.0, 3.0]);
        let second = StandardMaterial { base_color_channel: UvChannel::Uv1, ..Default::default() };
        assert_eq!(most(StandardMaterial { uv_transform, ..second }), [20.0, 9.0]);
    }

    #[test]
    fn alpha_to_coverage_is_baked_as_a_mask() {
        let alpha_mode = BevyAlphaMode::AlphaToCoverage;
        let scene = plane_of(StandardMaterial { alpha_mode, ..Default::default() });
        assert!(scene.instances[0].casts);
        assert_eq!(scene.materials[0].alpha, AlphaMode::Mask { cutoff: 0.5 });
    }

    #[test]
    fn blended_material_casts_where_alpha_is_at_least_half() {
        let base_color = Color::srgba(1.0, 1.0, 1.0, 0.3);
        let blends = StandardMaterial { alpha_mode: BevyAlphaMode::Blend, base_color, ..Default::default() };
        let material = &plane_of(blends).materials[0];
        assert!(material.blended && material.alpha == AlphaMode::Mask { cutoff: 0.5 });
        assert_eq!(material.base_color[3], 0.3);
    }

    #[test]
    fn the_finest_of_several_levels_of_detail_casts() {
        let (mesh, at) = (Mesh3d::default(), GlobalTransform::default());
        let casts = |range: Option<&VisibilityRange>| {
            Placed::from((Entity::PLACEHOLDER, &mesh, &at, None, false, range)).casts
        };
        assert!(casts(None) && casts(Some(&VisibilityRange::abrupt(0.0, 10.0))));
        assert!(!casts(Some(&VisibilityRange::abrupt(10.0, 20.0))));
    }
}
