//! The keys of a bake's entries: hashes of everything that their pages depend on.

use adumbra::{Bias, LightGrid, Receivers};
use adumbra_scene::{AlphaMode, Material, Mesh, Pixels, Scene, Texture, Wrap};
use blake3::{Hash, Hasher};
use rayon::prelude::*;

use crate::cache::CacheKey;
use crate::options::ColumnBuilder;
use crate::plan::Plan;

/// Version of the rules by which pages are made. A test in `tests/cache.rs` fails if pages change.
const RULES: u32 = 3;

/// The hashes of a scene's instances, with their meshes, materials and textures.
pub(crate) struct SceneHashes {
    instances: Vec<Hash>,
}

impl SceneHashes {
    /// Hashes a scene. Cost: one pass over its meshes and textures.
    pub(crate) fn new(scene: &Scene) -> Self {
        let textures: Vec<Hash> = scene.textures.par_iter().map(texture).collect();
        let materials: Vec<Hash> = scene.materials.iter().map(|m| material(m, &textures)).collect();
        let meshes: Vec<Hash> = scene.meshes.par_iter().map(|m| mesh(m, &materials)).collect();
        Self { instances: instances(scene, &meshes) }
    }

    /// Returns a hash of the whole scene.
    pub(crate) fn all(&self) -> Hash {
        let mut hasher = Hasher::new();
        hash_each(&mut hasher, self.instances.iter().map(|instance| *instance.as_bytes()));
        hasher.finalize()
    }

    /// Returns the key of each item, which consists of some root blocks of a plan's grid. Cost: one pass over
    /// the clusters in reach of the root blocks.
    pub(crate) fn keys<I: Iterator<Item = usize>>(
        &self,
        plan: &Plan<'_>,
        builder: ColumnBuilder,
        items: &[usize],
        root_blocks_of: impl Fn(usize) -> I + Sync,
    ) -> Vec<CacheKey> {
        let all = common(plan, builder);
        let key = |&item: &usize| {
            let mut hasher = Hasher::new();
            hasher.update(all.as_bytes());
            for root_block in root_blocks_of(item) {
                let rect = plan.root_blocks.rect(root_block);
                let placed = plan.root_blocks.casters.in_bin(root_block);
                let numbers = [rect.x, rect.y, rect.width, rect.height, placed.len() as u32];
                hash_each(&mut hasher, numbers.map(u32::to_le_bytes));
                for placed in placed {
                    hasher.update(self.instances[placed.instance as usize].as_bytes());
                    hasher.update(&placed.cluster.to_le_bytes());
                }
            }
            CacheKey::new(*hasher.finalize().as_bytes())
        };
        items.par_iter().map(key).collect()
    }
}

fn common(plan: &Plan<'_>, builder: ColumnBuilder) -> Hash {
    let LightGrid { sun, frame: _, voxel_size, corner, axes, edges, size } = plan.root_blocks.grid;
    let settings = &plan.settings;
    let Bias { constant_texels, slope_texels, normal_offset_texels } = settings.bias;
    let mut hasher = Hasher::new();
    hasher.update(b"adumbra entry");
    let receivers = match settings.receivers {
        Receivers::All => 0,
        Receivers::Static => 1,
    };
    let builder = match builder {
        ColumnBuilder::Fast => 0,
        ColumnBuilder::Plain => 1,
    };
    let flags = u32::from(settings.assume_ground)
        | u32::from(settings.closed_regions) << 1
        | u32::from(settings.ignore_alpha) << 2;
    let level = plan.root_blocks.root_level;
    let numbers = [RULES, level, size[2], builder, receivers, flags, settings.switch_within_voxels];
    hash_each(&mut hasher, numbers.map(u32::to_le_bytes));
    let lengths = [voxel_size, settings.thickness_world, 0.0];
    let bias = [constant_texels, slope_texels, normal_offset_texels];
    let towards = sun.towards();
    let reals = axes.iter().chain(&edges).chain([&corner, &towards, &lengths, &bias]).flatten();
    hash_each(&mut hasher, reals.map(|number| number.to_le_bytes()));
    hasher.finalize()
}

/// Hashes each item's bytes.
pub(crate) fn hash_each<const N: usize>(hasher: &mut Hasher, items: impl IntoIterator<Item = [u8; N]>) {
    for bytes in items {
        hasher.update(&bytes);
    }
}

fn texture(texture: &Texture) -> Hash {
    let Texture { name: _, width, height, pixels, wrap, nearest } = texture;
    let (channels, bytes) = match pixels {
        Pixels::Alpha(bytes) => (1, bytes),
        Pixels::Rgba(bytes) => (4, bytes),
    };
    let number_of = |wrap: &Wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::Mirror => 1,
        Wrap::Clamp => 2,
    };
    let mut hasher = Hasher::new();
    let [u, v] = wrap.each_ref().map(number_of);
    hash_each(&mut hasher, [*width, *height, channels, u, v, u32::from(*nearest)].map(u32::to_le_bytes));
    hasher.update(bytes);
    hasher.finalize()
}

fn material(material: &Material, textures: &[Hash]) -> Hash {
    let Material { name: _, base_color, texture, alpha, blended, transmissivity, casts } = material;
    let mut hasher = Hasher::new();
    let flags = [*blended, *transmissivity > 0.0, *casts].map(u8::from);
    hasher.update(&flags);
    match alpha {
        AlphaMode::Opaque => hasher.update(&[0]),
        // Only masked materials use the opacity.
        AlphaMode::Mask { cutoff } => {
            hasher.update(&[1]);
            hasher.update(&cutoff.to_bits().to_le_bytes());
            hasher.update(&base_color[3].to_bits().to_le_bytes());
            match texture {
                None => hasher.update(&[0]),
                Some(number) => hasher.update(&[1]).update(textures[*number as usize].as_bytes()),
            }
        }
    };
    hasher.finalize()
}

fn mesh(mesh: &Mesh, materials: &[Hash]) -> Hash {
    let Mesh { name: _, positions, uvs, colors, triangles, triangle_materials } = mesh;
    let mut hasher = Hasher::new();
    let mut bytes = Vec::new();
    let mut section = |fill: &mut dyn FnMut(&mut Vec<u8>)| {
        bytes.clear();
        fill(&mut bytes);
        hasher.update(&(bytes.len() as u64).to_le_bytes());
        hasher.update(&bytes);
    };
    section(&mut |b| positions.as_flattened().iter().for_each(|x| b.extend(x.to_bits().to_le_bytes())));
    section(&mut |b| uvs.as_flattened().iter().for_each(|x| b.extend(x.to_bits().to_le_bytes())));
    section(&mut |b| b.extend(colors.iter().map(|color| color[3])));
    section(&mut |b| triangles.as_flattened().iter().for_each(|v| b.extend(v.to_le_bytes())));
    // Coincident triangles are sorted by material number, so the pages depend on the numbers.
    section(&mut |b| triangle_materials.iter().for_each(|m| b.extend(m.to_le_bytes())));
    let mut used = triangle_materials.clone();
    used.sort_unstable();
    used.dedup();
    section(&mut |b| used.iter().for_each(|&m| b.extend(materials[m as usize].as_bytes())));
    hasher.finalize()
}

fn instances(scene: &Scene, meshes: &[Hash]) -> Vec<Hash> {
    let of_instance = |instance: &adumbra_scene::Instance| {
        let adumbra_scene::Instance { name: _, mesh, world_from_mesh, casts } = instance;
        let mut hasher = Hasher::new();
        hasher.update(meshes[*mesh as usize].as_bytes());
        hash_each(&mut hasher, world_from_mesh.as_flattened().iter().map(|number| number.to_le_bytes()));
        hasher.update(&[u8::from(*casts)]);
        hasher.finalize()
    };
    scene.instances.par_iter().map(of_instance).collect()
}
