//! Node animations: which nodes move, and their keys. Animated morph weights and animation pointers are
//! ignored, and skins do not follow animated joints.

use std::path::Path;

use ::gltf::json::Root;
use ::gltf::json::animation::{Animation, Channel, Interpolation as Kind, Property};
use ::gltf::json::validation::Checked;
use hashbrown::HashMap;

use crate::affine::{Affine, IDENTITY, multiply};
use crate::gltf::accessor::Accessor;
use crate::gltf::container::Buffers;
use crate::gltf::extents::Extents;
use crate::gltf::faults::bad;
use crate::movers::{Interpolation, MovingNode, Track, Tracks};
use crate::{LoadNotes, Result};

/// The animation channels that the loader leaves out, as a plural: those that an extension defines.
pub(super) const OTHER_CHANNELS: &str = "animations of other things than nodes";

/// The animated nodes of a file.
#[derive(Default)]
pub(super) struct Animations {
    /// Animated nodes, each after its nearest animated ancestor.
    pub(super) moving: Vec<MovingNode>,
    /// For every node that moves, the index into `moving` and the map to that node.
    hangs_on: Vec<Option<(u32, Affine)>>,
}

impl Animations {
    /// Reads every channel that moves a node. All animations play together. If two channels animate the same
    /// property, the first one is used, with a warning. Tracks that move nothing by more than rounding
    /// ([`Extents::are_moved`]) do not make a mover. A matrix on an animated node, which glTF forbids, is
    /// decomposed, with a warning.
    pub(super) fn load(
        path: &Path,
        root: &Root,
        buffers: &Buffers<'_>,
        extents: &Extents<'_>,
        notes: &mut LoadNotes,
    ) -> Result<Self> {
        let mut of_node: HashMap<usize, Tracks> = HashMap::new();
        let mut others = 0;
        let (mut twice, mut matrices, mut morphs, mut broken) = (0_u32, 0_u32, 0_u64, 0_u64);
        for (index, animation) in root.animations.iter().enumerate() {
            for channel in &animation.channels {
                let node = channel.target.node.value();
                let what = |what: &str| bad(path, format!("animation {index} of node {node} {what}"));
                let json = root.nodes.get(node).ok_or_else(|| what("moves a node that does not exist"))?;
                let Checked::Valid(property) = channel.target.path else {
                    others += 1;
                    continue;
                };
                if property == Property::MorphTargetWeights {
                    morphs += 1;
                    continue;
                }
                let tracks = of_node.entry(node).or_insert_with(|| {
                    matrices += u32::from(json.matrix.is_some());
                    Tracks::default()
                });
                let reader = Reader { path, root, buffers, animation, channel, what: &what };
                if animation.samplers.get(channel.sampler.value()).is_none() {
                    broken += 1;
                    continue;
                }
                let fresh = match property {
                    Property::Translation => set(&mut tracks.translation, reader.track()?),
                    Property::Scale => set(&mut tracks.scale, reader.track()?),
                    _ => set(&mut tracks.rotation, reader.track()?),
                };
                twice += u32::from(!fresh);
            }
        }
        if twice > 0 {
            notes.warnings.push(format!(
                "{twice} animation channels move what an earlier channel moves; the first is used"
            ));
        }
        if matrices > 0 {
            notes.warnings.push(format!(
                "{matrices} animated nodes have a matrix, which glTF forbids; their animations replace its parts"
            ));
        }
        notes.omit("animations of morph weights", morphs);
        notes.omit(OTHER_CHANNELS, others);
        notes.omit("animation channels without a sampler", broken);
        notes.omit("animations that cannot be read", buffers.faults.count("animation"));
        Ok(Self::of(extents, of_node))
    }

    fn of(extents: &Extents<'_>, mut of_node: HashMap<usize, Tracks>) -> Self {
        let nodes = extents.nodes;
        let mut all = Self { moving: Vec::new(), hangs_on: vec![None; nodes.transforms.len()] };
        for &node in &nodes.order {
            let above = nodes.parent[node].and_then(|p| all.hangs_on[p]);
            let rest = nodes.transforms[node].rest();
            let tracks = of_node.remove(&node).filter(|tracks| extents.are_moved(node, &rest, tracks));
            all.hangs_on[node] = match tracks {
                Some(tracks) => {
                    let fixed = nodes.parent[node].map_or(IDENTITY, |p| nodes.world[p]);
                    let (parent, above) = above.map_or((None, fixed), |(on, map)| (Some(on), map));
                    all.moving.push(MovingNode { parent, above, rest, tracks });
                    Some((all.moving.len() as u32 - 1, IDENTITY))
                }
                None => above.map(|(on, map)| (on, multiply(&map, &nodes.transforms[node].map()))),
            };
        }
        all
    }

    /// The moving node that this node is, or descends from, and the map to it; `None` for static nodes.
    pub(super) fn of_node(&self, node: usize) -> Option<(u32, Affine)> {
        self.hangs_on.get(node).copied().flatten()
    }

    /// Whether any joint of a skin moves.
    pub(super) fn moves_skin(&self, root: &Root, skin: usize) -> bool {
        root.skins.get(skin).is_some_and(|s| s.joints.iter().any(|j| self.of_node(j.value()).is_some()))
    }
}

/// Sets `place` if it is empty, and returns whether it was.
fn set<T>(place: &mut Option<T>, value: T) -> bool {
    let free = place.is_none();
    place.get_or_insert(value);
    free
}

/// Reads one channel of an animation.
struct Reader<'a, E> {
    path: &'a Path,
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    animation: &'a Animation,
    channel: &'a Channel,
    what: E,
}

impl<E: Fn(&str) -> crate::Error> Reader<'_, E> {
    fn track<const N: usize>(&self) -> Result<Track<N>> {
        let sampler = self.animation.samplers.get(self.channel.sampler.value());
        let sampler = sampler.ok_or_else(|| (self.what)("has a sampler that does not exist"))?;
        let Checked::Valid(kind) = sampler.interpolation else {
            return Err((self.what)("has an unknown interpolation"));
        };
        let interpolation = match kind {
            Kind::Step => Interpolation::Step,
            Kind::Linear => Interpolation::Linear,
            Kind::CubicSpline => Interpolation::Cubic,
        };
        let open = |accessor: usize| Accessor::open(self.path, self.root, self.buffers, accessor);
        let (times, values) = (open(sampler.input.value())?, open(sampler.output.value())?);
        if times.components != 1 || values.components != N {
            return Err((self.what)("has keys of the wrong type"));
        }
        let bytes = 4 * (times.count as u64 + (N * values.count) as u64);
        let what = || format!("the keys of node {}", self.channel.target.node.value());
        self.buffers.sources.budget.charge(bytes, what)?;
        let times: Vec<f32> = (0..times.count).filter_map(|i| times.floats::<1>(i)).map(|[t]| t).collect();
        let values: Vec<[f32; N]> = (0..values.count).filter_map(|i| values.floats(i)).collect();
        Track::new(times, values, interpolation).ok_or_else(|| {
            (self.what)(
                "has keys that are not finite, are out of order, or do not match its interpolation in number",
            )
        })
    }
}
