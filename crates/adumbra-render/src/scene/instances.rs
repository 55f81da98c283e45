//! Placement of instances, and culling to what a view sees.

use adumbra::Bounds;
use adumbra_scene::Scene;

use super::SceneBuffers;
use crate::gpu::Gpu;

/// Bytes of an instance: three rows of four floats.
pub(super) const INSTANCE_BYTES: u64 = 48;

/// A convex volume: points with `xyz · p + w >= 0` for each plane, world space.
#[derive(Clone, Debug, Default)]
pub struct Volume {
    /// The planes. An empty list means all of space.
    pub planes: Vec<[f64; 4]>,
}

impl Volume {
    /// Whether a box may intersect the volume. Conservative: it may return true for a box outside, never
    /// false for one that intersects.
    pub fn may_touch(&self, center: [f64; 3], half: [f64; 3]) -> bool {
        self.planes.iter().all(|p| {
            let distance: f64 = (0..3).map(|a| p[a] * center[a]).sum::<f64>() + p[3];
            let reach: f64 = (0..3).map(|a| p[a].abs() * half[a]).sum();
            distance + reach >= 0.0
        })
    }
}

struct Instance {
    /// Transform from the uploaded mesh to the world. Uploaded positions are relative to [`mesh_origin`].
    world: [[f64; 4]; 3],
    center: [f64; 3],
    half: [f64; 3],
    casts: bool,
}

/// Instances sorted by mesh, with their bounding boxes.
pub(super) struct Placed {
    instances: Vec<Instance>,
    /// Index of each mesh's first instance, then the number of instances.
    starts: Vec<usize>,
    first_world: [f64; 3],
}

impl Placed {
    pub(super) fn new(scene: &Scene) -> Self {
        let extents: Vec<_> = scene.meshes.iter().map(|m| mesh_extent(&m.positions)).collect();
        let mut order: Vec<usize> =
            (0..scene.instances.len()).filter(|&i| has_place(&scene.instances[i])).collect();
        order.sort_by_key(|&i| scene.instances[i].mesh);
        let mut starts = vec![0; scene.meshes.len() + 1];
        for &i in &order {
            starts[scene.instances[i].mesh as usize + 1] += 1;
        }
        for m in 0..scene.meshes.len() {
            starts[m + 1] += starts[m];
        }
        let instances = order.into_iter().map(|i| {
            let instance = &scene.instances[i];
            let extent = extents[instance.mesh as usize];
            let [center, half] = [middle, half_extent].map(|of| of(extent));
            let world = instance.world_from_mesh;
            let origin = nearest_to_zero(extent);
            Instance {
                world: world.map(|[x, y, z, w]| [x, y, z, x * origin[0] + y * origin[1] + z * origin[2] + w]),
                center: world.map(|r| (0..3).map(|a| r[a] * center[a]).sum::<f64>() + r[3]),
                half: world.map(|r| (0..3).map(|a| r[a].abs() * half[a]).sum()),
                casts: instance.casts,
            }
        });
        let first = scene.instances.iter().find(|i| has_place(i));
        let first_world = first.map_or([0.0; 3], |i| i.world_from_mesh.map(|row| row[3]));
        Self { instances: instances.collect(), starts, first_world }
    }

    /// Bounding boxes of the instances, world space.
    pub(super) fn boxes(&self) -> impl Iterator<Item = Bounds> {
        self.instances.iter().map(|i| Bounds {
            min: std::array::from_fn(|a| i.center[a] - i.half[a]),
            max: std::array::from_fn(|a| i.center[a] + i.half[a]),
        })
    }

    /// World position of the first instance in the scene's order.
    pub(super) fn first_world(&self) -> [f64; 3] {
        self.first_world
    }

    pub(super) fn len(&self) -> usize {
        self.instances.len()
    }
}

/// Whether an instance has a finite transform. Instances without one are neither drawn nor part of a bounding
/// box.
fn has_place(instance: &adumbra_scene::Instance) -> bool {
    instance.world_from_mesh.iter().flatten().all(|&c| (c as f32).is_finite())
}

/// Returns the bounding box of all instances. Cost: one pass over the instanced vertices.
pub(super) fn bounds(scene: &Scene) -> Bounds {
    if scene.instances.iter().all(has_place) {
        return scene.bounds();
    }
    let mut b = Bounds { min: [f64::INFINITY; 3], max: [f64::NEG_INFINITY; 3] };
    for instance in scene.instances.iter().filter(|i| has_place(i)) {
        let mesh = &scene.meshes[instance.mesh as usize];
        for &corner in mesh.triangles.iter().flatten() {
            let p_world = instance.to_world(mesh.positions[corner as usize]);
            for (a, c) in p_world.into_iter().enumerate() {
                (b.min[a], b.max[a]) = (b.min[a].min(c), b.max[a].max(c));
            }
        }
    }
    b
}

/// Returns the origin of a mesh's positions on the GPU: the point of its bounding box nearest to zero. A mesh
/// far from its own zero thus keeps as much precision as one around it.
pub(super) fn mesh_origin(positions: &[[f32; 3]]) -> [f64; 3] {
    nearest_to_zero(mesh_extent(positions))
}

/// Returns the least and greatest corner of a mesh's bounding box; zero for a mesh without positions.
fn mesh_extent(positions: &[[f32; 3]]) -> [[f64; 3]; 2] {
    if positions.is_empty() {
        return [[0.0; 3]; 2];
    }
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for p in positions {
        for a in 0..3 {
            low[a] = low[a].min(f64::from(p[a]));
            high[a] = high[a].max(f64::from(p[a]));
        }
    }
    [low, high]
}

fn nearest_to_zero([low, high]: [[f64; 3]; 2]) -> [f64; 3] {
    std::array::from_fn(|a| low[a].max(0.0) + high[a].min(0.0))
}

fn middle([low, high]: [[f64; 3]; 2]) -> [f64; 3] {
    std::array::from_fn(|a| 0.5 * (high[a] + low[a]))
}

fn half_extent([low, high]: [[f64; 3]; 2]) -> [f64; 3] {
    std::array::from_fn(|a| 0.5 * (high[a] - low[a]))
}

/// The instances that one view draws, on the GPU.
pub struct InstanceList {
    label: String,
    buffer: wgpu::Buffer,
    ranges: Vec<std::ops::Range<u32>>,
    count: u32,
}

impl InstanceList {
    /// Creates an empty list with room for every instance of `scene`.
    pub fn new(gpu: &Gpu, label: &str, scene: &SceneBuffers) -> Self {
        let buffer = rows_buffer(gpu, label, scene.placed.len() as u64);
        Self { label: label.to_owned(), buffer, ranges: Vec::new(), count: 0 }
    }

    /// Lists the instances that may intersect `volume`, with transforms relative to `anchor_world`; only
    /// shadow casters if `casters_only`. Cost: one test per instance, and 48 bytes uploaded per listed
    /// instance. Allocates a new buffer if the list outgrows the present one.
    pub fn update(
        &mut self,
        gpu: &Gpu,
        scene: &SceneBuffers,
        anchor_world: [f64; 3],
        volume: &Volume,
        casters_only: bool,
    ) {
        // Double precision up to here: at map coordinates, the spacing of floats is half a metre.
        let rows_of = |i: &Instance| -> [[f32; 4]; 3] {
            std::array::from_fn(|a| {
                let [x, y, z, w] = i.world[a];
                [x, y, z, w - anchor_world[a]].map(|c| c as f32)
            })
        };
        let placed = &scene.placed;
        let mut rows: Vec<[[f32; 4]; 3]> = Vec::with_capacity(placed.instances.len());
        self.ranges.clear();
        for mesh in placed.starts.windows(2) {
            let start = rows.len() as u32;
            rows.extend(
                placed.instances[mesh[0]..mesh[1]]
                    .iter()
                    .filter(|i| (i.casts || !casters_only) && volume.may_touch(i.center, i.half))
                    .map(rows_of),
            );
            self.ranges.push(start..rows.len() as u32);
        }
        self.count = rows.len() as u32;
        if rows.len() as u64 * INSTANCE_BYTES > self.buffer.size() {
            // The buffer was made for another scene with fewer instances.
            self.buffer = rows_buffer(gpu, &self.label, placed.len() as u64);
        }
        if !rows.is_empty() {
            gpu.queue.write_buffer(&self.buffer, 0, bytemuck::cast_slice(&rows));
        }
    }

    /// Number of instances listed.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Size on the GPU, bytes.
    pub fn bytes(&self) -> u64 {
        self.buffer.size()
    }

    pub(super) fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    pub(super) fn ranges(&self) -> &[std::ops::Range<u32>] {
        &self.ranges
    }
}

fn rows_buffer(gpu: &Gpu, label: &str, count: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: count.max(1) * INSTANCE_BYTES,
        usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use adumbra_scene::{GeneratedKind, generate};

    #[test]
    fn skips_instances_without_a_finite_transform() {
        let mut scene = generate(GeneratedKind::Primitives, 1);
        let fine = scene.bounds();
        for broken in [f64::NAN, f64::INFINITY, 1e300] {
            let mut instance = scene.instances[0].clone();
            instance.world_from_mesh[1][3] = broken;
            scene.instances.push(instance);
        }
        assert_eq!(Placed::new(&scene).len(), scene.instances.len() - 3);
        assert_eq!(bounds(&scene), fine);
        assert!(Placed::new(&scene).boxes().all(|b| b.diagonal().is_finite()));
    }

    #[test]
    fn may_touch_keeps_boxes_that_may_intersect() {
        let volume = Volume { planes: vec![[1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 0.0, 10.0]] };
        assert!(volume.may_touch([5.0, 0.0, 0.0], [0.1; 3]));
        assert!(volume.may_touch([-1.0, 0.0, 0.0], [1.5, 0.0, 0.0]));
        assert!(!volume.may_touch([-1.0, 0.0, 0.0], [0.5; 3]));
        assert!(!volume.may_touch([12.0, 3.0, 0.0], [1.0; 3]));
        assert!(Volume::default().may_touch([1e9; 3], [0.0; 3]));
    }
}
