//! Movers: instances that move over time. A bake holds static geometry only, so it excludes them. They
//! receive baked shadows and cast through shadow maps.
//!
//! Only the nodes that determine a mover's transform are kept: the animated ones, each with the map to its
//! nearest animated ancestor. Animation follows glTF 2.0; all of a file's animations play together, from
//! second 0.

mod track;

use crate::affine::{Affine, IDENTITY, compose, multiply};
use crate::generate::unit_ball;
use crate::{Instance, Material, Scene};
pub(super) use track::{Interpolation, Track};

/// How a load treats instances that an animation moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MoverPolicy {
    /// They are dropped and counted in [`crate::LoadNotes::skipped_movers`]; the remaining scene can be
    /// baked.
    #[default]
    Skip,
    /// They stay in their first pose and are static like everything else.
    Freeze,
    /// They move: [`Scene::movers`] lists them.
    Keep,
}

/// The instances of a scene that move, by ascending index.
#[derive(Clone, Debug, Default)]
pub struct Movers {
    list: Vec<Mover>,
    /// The moving nodes; each comes after its parent.
    nodes: Vec<MovingNode>,
}

/// An instance that moves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mover {
    /// Index into [`Scene::instances`].
    pub(super) instance: u32,
    /// Index into the moving nodes.
    pub(super) node: u32,
    pub(super) node_from_mesh: Affine,
}

/// The transform of a node without animation.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rest {
    pub(super) translation: [f64; 3],
    /// x, y, z, w.
    pub(super) rotation: [f64; 4],
    pub(super) scale: [f64; 3],
}

impl Default for Rest {
    fn default() -> Self {
        Self { translation: [0.0; 3], rotation: [0.0, 0.0, 0.0, 1.0], scale: [1.0; 3] }
    }
}

/// The animated properties of a node.
#[derive(Clone, Debug, Default)]
pub(super) struct Tracks {
    pub(super) translation: Option<Track<3>>,
    pub(super) rotation: Option<Track<4>>,
    pub(super) scale: Option<Track<3>>,
}

/// An animated node.
#[derive(Clone, Debug)]
pub(super) struct MovingNode {
    /// The nearest animated ancestor.
    pub(super) parent: Option<u32>,
    /// The map from this node's parent to `parent`, or to the world.
    pub(super) above: Affine,
    pub(super) rest: Rest,
    pub(super) tracks: Tracks,
}

impl Rest {
    /// The map to the parent's frame.
    pub(super) fn map(&self) -> Affine {
        compose(self.translation, self.rotation, self.scale)
    }
}

impl Tracks {
    /// Times, in seconds, at which to sample the motion: the keys, and moments between each two keys, where
    /// the tangents of a spline weigh most, alone or against each other.
    pub(super) fn moments(&self) -> impl Iterator<Item = f64> {
        let translation = self.translation.iter().flat_map(Track::moments);
        let rotation = self.rotation.iter().flat_map(Track::moments);
        translation.chain(rotation).chain(self.scale.iter().flat_map(Track::moments))
    }

    fn end_seconds(&self) -> f64 {
        let ends = [
            self.translation.as_ref().map(Track::end_seconds),
            self.rotation.as_ref().map(Track::end_seconds),
            self.scale.as_ref().map(Track::end_seconds),
        ];
        ends.into_iter().flatten().fold(0.0, f64::max)
    }

    /// The map to the parent's frame at a time.
    pub(super) fn at(&self, rest: &Rest, seconds: f64) -> Affine {
        let translation = self.translation.as_ref().map(|t| t.at(seconds));
        let rotation = self.rotation.as_ref().map(|t| t.at(seconds));
        let scale = self.scale.as_ref().map(|t| t.at(seconds));
        compose(
            translation.unwrap_or(rest.translation),
            rotation.unwrap_or(rest.rotation),
            scale.unwrap_or(rest.scale),
        )
    }
}

impl Movers {
    /// Updates the indices after the removal of all instances that are not `kept`. No removed instance may be
    /// a mover.
    pub(super) fn forget(&mut self, kept: &[bool]) {
        for mover in &mut self.list {
            mover.instance = kept[..mover.instance as usize].iter().filter(|&&kept| kept).count() as u32;
        }
    }

    pub(super) fn new(list: Vec<Mover>, nodes: Vec<MovingNode>) -> Self {
        Self { list, nodes }
    }

    /// Number of instances that move.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether nothing moves.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// Indices into [`Scene::instances`], ascending.
    pub fn instances(&self) -> impl Iterator<Item = u32> + '_ {
        self.list.iter().map(|m| m.instance)
    }

    /// Whether this instance moves. Cost: a binary search.
    pub fn contains(&self, instance: u32) -> bool {
        self.list.binary_search_by_key(&instance, |m| m.instance).is_ok()
    }

    /// Time of the last key, seconds; nothing moves after it.
    pub fn end_seconds(&self) -> f64 {
        self.nodes.iter().map(|n| n.tracks.end_seconds()).fold(0.0, f64::max)
    }

    /// The `world_from_mesh` of each mover at a time, in the order of [`Movers::instances`]. Cost: a few
    /// hundred operations per animated node. If keys multiply to numbers beyond `f64`, the map is not finite,
    /// and rays skip the mover.
    pub fn pose(&self, seconds: f64) -> Vec<[[f64; 4]; 3]> {
        let mut world: Vec<Affine> = Vec::with_capacity(self.nodes.len());
        for node in &self.nodes {
            let above = node.parent.map_or(node.above, |p| multiply(&world[p as usize], &node.above));
            world.push(multiply(&above, &node.tracks.at(&node.rest, seconds)));
        }
        self.list.iter().map(|m| multiply(&world[m.node as usize], &m.node_from_mesh)).collect()
    }

    /// Adds a mover with its own node. Instances must be added in ascending order.
    fn add(&mut self, instance: u32, above: Affine, rest: Rest, tracks: Tracks) {
        self.nodes.push(MovingNode { parent: None, above, rest, tracks });
        self.list.push(Mover { instance, node: self.nodes.len() as u32 - 1, node_from_mesh: IDENTITY });
    }
}

impl Scene {
    /// Moves every mover to its pose at a time, for bounds, rays and pictures.
    pub fn pose(&mut self, seconds: f64) {
        let poses = self.movers.pose(seconds);
        for (mover, world_from_mesh) in self.movers.list.iter().zip(poses) {
            self.instances[mover.instance as usize].world_from_mesh = world_from_mesh;
        }
    }

    /// Removes every mover, along with meshes that nothing else uses; the remaining scene can be baked.
    /// Returns the number of movers removed.
    pub fn remove_movers(&mut self) -> usize {
        let movers = std::mem::take(&mut self.movers);
        self.retain_instances(|instance| !movers.contains(instance));
        movers.len()
    }

    /// Splits off the movers. This scene keeps the static instances; the returned scene holds the movers,
    /// their meshes, materials and animations ([`Scene::pose`]). Cost: a copy of the movers' meshes and of
    /// the textures that materials use.
    pub fn take_movers(&mut self) -> Self {
        let movers = std::mem::take(&mut self.movers);
        let instance = |i: u32| self.instances[i as usize].clone();
        let mut moving = Self {
            instances: movers.instances().map(instance).collect(),
            meshes: Vec::new(),
            materials: self.materials.clone(),
            textures: if movers.is_empty() { Vec::new() } else { self.textures.clone() },
            movers: Movers {
                list: (0..).zip(&movers.list).map(|(i, m)| Mover { instance: i, ..*m }).collect(),
                nodes: movers.nodes.clone(),
            },
            ..Self::default()
        };
        let mut mesh_index = vec![None; self.meshes.len()];
        for instance in &mut moving.instances {
            let mesh = instance.mesh as usize;
            instance.mesh = *mesh_index[mesh].get_or_insert_with(|| {
                moving.meshes.push(self.meshes[mesh].clone());
                moving.meshes.len() as u32 - 1
            });
        }
        self.retain_instances(|instance| !movers.contains(instance));
        moving
    }

    /// Adds a ball that moves along `path`, a list of seconds and centre positions, linearly interpolated.
    /// Returns its instance.
    ///
    /// The ball has 1,280 triangles whose corners are on the sphere. `base_color` is linear. Times must be
    /// finite and must not decrease. If `path` violates this or is empty, nothing is added and the result is
    /// `None`.
    pub fn add_ball(
        &mut self,
        radius_world: f64,
        base_color: [f32; 4],
        path: &[(f64, [f64; 3])],
    ) -> Option<u32> {
        let times = path.iter().map(|p| p.0 as f32).collect();
        // Relative to the first position, so that `f32` is precise enough.
        let (_, [x, y, z]) = *path.first()?;
        let places = path.iter().map(|&(_, p)| [p[0] - x, p[1] - y, p[2] - z].map(|c| c as f32)).collect();
        let translation = Some(Track::new(times, places, Interpolation::Linear)?);
        let rest = Rest { scale: [radius_world; 3], ..Rest::default() };
        let above = [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z]];
        let material = self.materials.len() as u32;
        self.materials.push(Material::opaque("ball", base_color));
        let (mesh, instance) = (self.meshes.len() as u32, self.instances.len() as u32);
        self.meshes.push(unit_ball("ball", material));
        let world_from_mesh = IDENTITY;
        self.instances.push(Instance { name: "ball".to_owned(), mesh, world_from_mesh, casts: true });
        self.movers.add(instance, above, rest, Tracks { translation, ..Tracks::default() });
        self.pose(path[0].0);
        Some(instance)
    }

    /// Keeps the instances for which `keep` is true, and the meshes that they use. There must be no movers.
    fn retain_instances(&mut self, mut keep: impl FnMut(u32) -> bool) {
        let mut index = 0;
        self.instances.retain(|_| {
            index += 1;
            keep(index - 1)
        });
        let mut placed = vec![false; self.meshes.len()];
        self.instances.iter().for_each(|i| placed[i.mesh as usize] = true);
        self.retain_meshes(|mesh| placed[mesh]);
    }

    /// Keeps the meshes for which `keep` is true, with their instances and movers, and renumbers them.
    pub(super) fn retain_meshes(&mut self, mut keep: impl FnMut(usize) -> bool) {
        let mut mesh_index = Vec::with_capacity(self.meshes.len());
        let mut kept = 0_u32;
        for mesh in 0..self.meshes.len() {
            let keeps = keep(mesh);
            mesh_index.push(keeps.then_some(kept));
            kept += u32::from(keeps);
        }
        if kept as usize == self.meshes.len() {
            return;
        }
        let mut index = 0;
        self.meshes.retain(|_| {
            index += 1;
            mesh_index[index - 1].is_some()
        });
        let mut instance_index = Vec::with_capacity(self.instances.len());
        let mut kept = 0_u32;
        self.instances.retain_mut(|instance| {
            let new = mesh_index[instance.mesh as usize];
            instance_index.push(new.map(|_| kept));
            kept += u32::from(new.is_some());
            instance.mesh = new.unwrap_or_default();
            new.is_some()
        });
        self.movers.list.retain_mut(|mover| {
            let new = instance_index[mover.instance as usize];
            mover.instance = new.unwrap_or_default();
            new.is_some()
        });
    }
}
