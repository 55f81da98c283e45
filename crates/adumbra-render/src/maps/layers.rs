//! The layers of a map from frame to frame: their placement, the casters drawn into them, and what is cached.

use super::cascades::LayerFit;
use super::depth_pass::{DepthPass, LayerUniform};
use super::textures::DepthTextures;
use crate::gpu::Gpu;
use crate::scene::InstanceList;
use crate::technique::FrameInput;

/// The state that a layer's static casters depend on.
#[derive(Clone, Copy)]
struct LayerInputs {
    fit: LayerFit,
    /// [`SceneBuffers::id`](crate::scene::SceneBuffers::id).
    scene: u64,
}

/// One layer.
pub(crate) struct Layer {
    uniform: LayerUniform,
    still: Option<InstanceList>,
    moving: Option<InstanceList>,
    /// Current placement.
    place: Option<LayerInputs>,
    /// Placement when the static casters were last drawn.
    drawn: Option<LayerInputs>,
    /// Whether static casters must be drawn in this frame.
    stale: bool,
    /// Whether the layer contains movers. If so, it must be redrawn even if nothing else changed.
    had_movers: bool,
}

impl Layer {
    pub(crate) fn new(gpu: &Gpu, pass: &DepthPass) -> Self {
        let uniform = pass.uniform(gpu);
        Self { uniform, still: None, moving: None, place: None, drawn: None, stale: true, had_movers: false }
    }

    /// Lists the casters of the layer at `fit`. With `keep`, static casters are listed only if the layer has
    /// moved or the scene has changed.
    pub(crate) fn prepare(
        &mut self,
        input: &FrameInput<'_>,
        fit: &LayerFit,
        static_casters: bool,
        keep: bool,
    ) {
        let gpu = input.gpu;
        self.uniform.write(gpu, &fit.layer(input.anchor_world));
        let scene = input.scene.id();
        self.stale = !keep || !self.drawn.is_some_and(|d| d.scene == scene && d.fit.same_place(fit));
        self.place = Some(LayerInputs { fit: *fit, scene });
        let volume = fit.caster_volume();
        if static_casters && self.stale {
            let list = self.still.get_or_insert_with(|| InstanceList::new(gpu, "map::still", input.scene));
            list.update(gpu, input.scene, input.anchor_world, &volume, true);
        }
        match input.movers {
            Some(movers) => {
                let list = self.moving.get_or_insert_with(|| InstanceList::new(gpu, "map::moving", movers));
                list.update(gpu, movers, input.anchor_world, &volume, true);
            }
            None => self.moving = None,
        }
    }

    /// Draws the layer and returns whether it changed. With `kept`, static casters are drawn there and
    /// copied, and movers are drawn over the copy.
    pub(crate) fn encode(
        &mut self,
        input: &FrameInput<'_>,
        pass: &DepthPass,
        encoder: &mut wgpu::CommandEncoder,
        index: usize,
        live: &DepthTextures,
        kept: Option<&DepthTextures>,
    ) -> bool {
        let still = self.still.as_ref().map(|list| (input.scene, list));
        let moving = input.movers.zip(self.moving.as_ref()).filter(|(_, list)| list.count() > 0);
        let target = live.target(index);
        let Some(kept) = kept else {
            let parts: Vec<_> = still.into_iter().chain(moving).collect();
            pass.encode(encoder, &self.uniform, target, false, &parts);
            return true;
        };
        if self.stale {
            let parts: Vec<_> = still.into_iter().collect();
            pass.encode(encoder, &self.uniform, kept.target(index), false, &parts);
            self.drawn = self.place;
        }
        let changed = self.stale || self.had_movers || moving.is_some();
        if changed {
            live.copy_layer(encoder, kept, index as u32);
        }
        if let Some(part) = moving {
            pass.encode(encoder, &self.uniform, target, true, &[part]);
        }
        self.had_movers = moving.is_some();
        changed
    }

    pub(crate) fn bytes(&self) -> u64 {
        self.still.iter().chain(&self.moving).map(InstanceList::bytes).sum()
    }
}
