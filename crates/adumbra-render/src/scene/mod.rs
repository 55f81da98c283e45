//! A scene on the GPU: each mesh once, instances sorted by mesh, and materials with their textures.
//!
//! | buffer | holds | read by |
//! |---|---|---|
//! | corners | three per triangle: position, the triangle's normal, texture coordinates, colour; sorted by mesh, then opaque before masked, then material | G-buffer, masked casters |
//! | positions, indices | shared vertices as in the file, indexed; opaque casters only | depth from the light |
//! | instances | rows of the transform from mesh to relative positions, sorted by mesh; one list per view, see [`InstanceList`] | both |
//!
//! Cost on the GPU: 32 bytes per corner, 12 per position, 4 per index, 48 per instance and view.

mod instances;
mod materials;
mod split;

pub use instances::{InstanceList, Volume};

use std::sync::atomic::{AtomicU64, Ordering};

use adumbra::{Bounds, LightExtent, Sun};
use adumbra_scene::{AlphaMode, Mesh, Scene};
use wgpu::BufferUsages;

use crate::error::{Fix, RenderError, Result};
use crate::gpu::Gpu;
use instances::{Placed, mesh_origin};
use materials::Materials;

/// Bytes of a corner: position 12, normal 8, texture coordinates 8, colour 4.
const CORNER_BYTES: u64 = 32;

fn next_id() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

/// A contiguous range of corners of one material.
#[derive(Clone, Debug)]
struct Run {
    material: u32,
    corners: std::ops::Range<u32>,
    masked: bool,
    casts: bool,
}

struct MeshRuns {
    runs: Vec<Run>,
    caster_indices: std::ops::Range<u32>,
    base_vertex: i32,
}

/// Options for uploading a scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct SceneOptions {
    /// Whether to treat every material as opaque.
    pub ignore_alpha: bool,
}

/// A scene on the GPU.
pub struct SceneBuffers {
    corners: wgpu::Buffer,
    positions: wgpu::Buffer,
    indices: wgpu::Buffer,
    meshes: Vec<MeshRuns>,
    materials: Materials,
    placed: Placed,
    bounds: Bounds,
    id: u64,
}

impl SceneBuffers {
    /// Uploads a scene, which must be valid, as those from [`adumbra_scene::load`] are. Cost: one pass over
    /// the stored triangles, and one over the instanced vertices for the bounds.
    ///
    /// # Errors
    /// Returns [`RenderError::TooLarge`] if a buffer or a texture is larger than the device allows.
    pub fn new(gpu: &Gpu, scene: &Scene, options: SceneOptions) -> Result<Self> {
        let mut corners = Vec::new();
        let mut positions: Vec<f32> = Vec::new();
        let mut indices: Vec<u32> = Vec::new();
        let mut meshes = Vec::new();
        let scales = split::largest_scales(scene);
        let longest_world = split::longest_edge(scene, &scales);
        for (mesh, scale) in scene.meshes.iter().zip(scales) {
            let mesh = split::split_long_edges(mesh, longest_world / scale);
            meshes.push(mesh_runs(scene, &mesh, options, &mut corners, &mut positions, &mut indices));
        }
        let check = |what: &str, bytes: usize| {
            let limit = gpu.device.limits().max_buffer_size;
            if bytes as u64 <= limit {
                return Ok(());
            }
            let fix = Fix::SmallerScene;
            Err(RenderError::TooLarge { what: what.to_owned(), bytes: bytes as u64, limit, fix })
        };
        check("the scene's corner buffer", corners.len())?;
        check("the scene's position buffer", positions.len() * 4)?;
        check("the scene's index buffer", indices.len() * 4)?;
        let bounds = instances::bounds(scene);
        Ok(Self {
            corners: gpu.buffer("scene::corners", &corners, BufferUsages::VERTEX),
            positions: gpu.buffer("scene::positions", bytemuck::cast_slice(&positions), BufferUsages::VERTEX),
            indices: gpu.buffer("scene::indices", bytemuck::cast_slice(&indices), BufferUsages::INDEX),
            meshes,
            materials: Materials::new(gpu, scene)?,
            placed: Placed::new(scene),
            bounds,
            id: next_id(),
        })
    }

    /// A number that identifies this content within the process. It changes when instances move.
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Bounding box of all instances, as last uploaded or moved.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// World position of the scene's first instance: a point that moves with the scene, whatever else is in
    /// it. Zero if there are no instances.
    pub(crate) fn lattice_world(&self) -> [f64; 3] {
        self.placed.first_world()
    }

    /// Returns the extent of all instances' bounding boxes along the light's axes. Cost: eight corners per
    /// instance.
    pub(crate) fn light_extent(&self, sun: &Sun) -> LightExtent {
        let mut extent = LightExtent::empty(sun);
        self.placed.boxes().for_each(|b| extent.add_box(&b));
        extent
    }

    /// Size on the GPU, textures included, bytes.
    pub fn bytes(&self) -> u64 {
        self.corners.size() + self.positions.size() + self.indices.size() + self.materials.bytes
    }

    /// Updates the transforms of the instances. `scene` must have the meshes and instances that this was
    /// created from.
    pub(crate) fn move_instances(&mut self, scene: &Scene) {
        self.placed = Placed::new(scene);
        self.bounds = instances::bounds(scene);
        self.id = next_id();
    }

    /// Draws every material of the listed instances. `bind` is called before opaque and before masked
    /// corners, with whether they are masked, to set the pipeline. Bind group 1 is the material's:
    /// [`material_layout`].
    pub(crate) fn draw_surfaces(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        list: &InstanceList,
        bind: impl Fn(&mut wgpu::RenderPass<'_>, bool),
    ) {
        self.draw_runs(pass, list, bind, |_| true);
    }

    /// Draws the opaque casters of the listed instances with positions only: vertex buffer 0 holds positions,
    /// 1 instances.
    pub(crate) fn draw_opaque_casters(&self, pass: &mut wgpu::RenderPass<'_>, list: &InstanceList) {
        if self.indices.size() <= 4 {
            return;
        }
        pass.set_vertex_buffer(0, self.positions.slice(..));
        pass.set_vertex_buffer(1, list.buffer().slice(..));
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        for (mesh, instances) in self.meshes.iter().zip(list.ranges()) {
            if !instances.is_empty() && !mesh.caster_indices.is_empty() {
                pass.draw_indexed(mesh.caster_indices.clone(), mesh.base_vertex, instances.clone());
            }
        }
    }

    /// Draws the masked casters of the listed instances. The vertex buffers are corners and instances, and
    /// bind group 1 is the material's. `bind` is called once before the first draw, and not at all if there
    /// is none.
    pub(crate) fn draw_masked_casters(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        list: &InstanceList,
        bind: impl Fn(&mut wgpu::RenderPass<'_>),
    ) {
        self.draw_runs(pass, list, |pass, _| bind(pass), |run| run.masked && run.casts);
    }

    /// Draws the corners of all casters of the listed instances, as [`SceneBuffers::draw_surfaces`] does for
    /// all surfaces.
    pub(crate) fn draw_caster_corners(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        list: &InstanceList,
        bind: impl Fn(&mut wgpu::RenderPass<'_>, bool),
    ) {
        self.draw_runs(pass, list, bind, |run| run.casts);
    }

    fn draw_runs(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        list: &InstanceList,
        bind: impl Fn(&mut wgpu::RenderPass<'_>, bool),
        wanted: impl Fn(&Run) -> bool,
    ) {
        for masked in [false, true] {
            let mut bound = false;
            let mut material = None;
            for (mesh, instances) in self.meshes.iter().zip(list.ranges()) {
                for run in mesh.runs.iter().filter(|run| run.masked == masked && wanted(run)) {
                    if instances.is_empty() {
                        continue;
                    }
                    if !bound {
                        bind(pass, masked);
                        pass.set_vertex_buffer(0, self.corners.slice(..));
                        pass.set_vertex_buffer(1, list.buffer().slice(..));
                        bound = true;
                    }
                    if material != Some(run.material) {
                        pass.set_bind_group(1, self.materials.group(run.material), &[]);
                        material = Some(run.material);
                    }
                    pass.draw(run.corners.clone(), instances.clone());
                }
            }
        }
    }
}

/// Creates the layout of a material's bind group: parameters, colour texture, sampler.
pub(crate) fn material_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    materials::layout(gpu)
}

/// Vertex buffers of a pipeline that draws corners: position, normal and texture coordinates at locations 0
/// to 2, instance rows at 3 to 5, colour (sRGB with linear alpha) at 6.
pub(crate) const CORNER_LAYOUT: [Option<wgpu::VertexBufferLayout<'static>>; 2] = [
    Some(wgpu::VertexBufferLayout {
        array_stride: CORNER_BYTES,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Snorm16x4, 2 => Float32x2, 6 => Unorm8x4],
    }),
    Some(INSTANCE_LAYOUT),
];

/// Vertex buffers of a pipeline that draws opaque casters: position at location 0, instance rows at 3 to 5.
pub(crate) const CASTER_LAYOUT: [Option<wgpu::VertexBufferLayout<'static>>; 2] = [
    Some(wgpu::VertexBufferLayout {
        array_stride: 12,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3],
    }),
    Some(INSTANCE_LAYOUT),
];

const INSTANCE_LAYOUT: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: instances::INSTANCE_BYTES,
    step_mode: wgpu::VertexStepMode::Instance,
    attributes: &wgpu::vertex_attr_array![3 => Float32x4, 4 => Float32x4, 5 => Float32x4],
};

fn mesh_runs(
    scene: &Scene,
    mesh: &Mesh,
    options: SceneOptions,
    corners: &mut Vec<u8>,
    positions: &mut Vec<f32>,
    indices: &mut Vec<u32>,
) -> MeshRuns {
    let base_vertex = (positions.len() / 3) as i32;
    let origin = mesh_origin(&mesh.positions);
    let local = |p: [f32; 3]| -> [f32; 3] { std::array::from_fn(|a| (f64::from(p[a]) - origin[a]) as f32) };
    positions.extend(mesh.positions.iter().flat_map(|&p| local(p)));
    let masked = |m: u32| !options.ignore_alpha && scene.materials[m as usize].alpha != AlphaMode::Opaque;
    let casts = |m: u32| scene.materials[m as usize].casts;
    let first_index = indices.len() as u32;
    let by_material: Vec<(u32, [u32; 3])> = {
        let mut triangles: Vec<_> =
            mesh.triangle_materials.iter().copied().zip(mesh.triangles.iter().copied()).collect();
        triangles.sort_by_key(|&(m, _)| (masked(m), m));
        triangles
    };
    let mut runs: Vec<Run> = Vec::new();
    for (material, triangle) in by_material {
        if casts(material) && !masked(material) {
            indices.extend(triangle);
        }
        let at = (corners.len() as u64 / CORNER_BYTES) as u32;
        push_corners(mesh, triangle, local, corners);
        match runs.last_mut() {
            Some(run) if run.material == material => run.corners.end = at + 3,
            _ => runs.push(Run {
                material,
                corners: at..at + 3,
                masked: masked(material),
                casts: casts(material),
            }),
        }
    }
    MeshRuns { runs, caster_indices: first_index..indices.len() as u32, base_vertex }
}

fn push_corners(
    mesh: &Mesh,
    triangle: [u32; 3],
    local: impl Fn([f32; 3]) -> [f32; 3],
    corners: &mut Vec<u8>,
) {
    let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].map(f64::from));
    let edge = |to: [f64; 3]| glam::DVec3::from(std::array::from_fn::<f64, 3, _>(|k| to[k] - a[k]));
    // Edges are normalised first, so that the cross product of a very small triangle does not underflow.
    let normal = edge(b).normalize_or_zero().cross(edge(c).normalize_or_zero()).normalize_or_zero();
    let packed = [normal.x, normal.y, normal.z].map(|c| (c * 32767.0).round() as i16);
    for i in triangle {
        local(mesh.positions[i as usize]).iter().for_each(|c| corners.extend(c.to_le_bytes()));
        packed.iter().for_each(|c| corners.extend(c.to_le_bytes()));
        corners.extend([0; 2]);
        let uv = mesh.uvs.get(i as usize).copied().unwrap_or_default();
        uv.iter().for_each(|c| corners.extend(c.to_le_bytes()));
        corners.extend(mesh.colors.get(i as usize).copied().unwrap_or([255; 4]));
    }
}
