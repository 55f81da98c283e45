//! Patches Bevy's shaders when they are loaded, and again when someone changes them.

use std::collections::BTreeSet;

use bevy::asset::{AssetEvent, AssetServer, Assets, Handle};
use bevy::ecs::prelude::*;
use bevy::log::error;
use bevy::shader::{Shader, Source};

use crate::error::BakedShadowError;
use crate::shaders::{PATCHES, WORDS, Way, look_up_module};

/// The state of Bevy's shaders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PatchState<'p> {
    /// Some are not loaded yet.
    Pending,
    /// All are patched.
    Done,
    /// One is not as expected.
    Failed(&'p BakedShadowError),
}

/// The look-up modules, and the patch state of Bevy's shaders.
#[derive(Resource)]
pub(crate) struct ShaderPatch {
    look_up: Handle<Shader>,
    /// Keeps the modules' assets alive.
    _modules: Vec<Handle<Shader>>,
    ways: BTreeSet<Way>,
    done: [bool; PATCHES.len()],
    failure: Option<BakedShadowError>,
}

impl ShaderPatch {
    /// Adds the modules. Nothing is patched yet.
    pub(crate) fn new(shaders: &mut Assets<Shader>) -> Self {
        let mut add = |name: &str, text: String| {
            shaders.add(Shader::from_wgsl(text, format!("bevy_adumbra/{name}.wgsl")))
        };
        let ways = BTreeSet::from([Way::Filtered]);
        let mut modules: Vec<_> = Way::ALL.map(|way| add(way.name(), way.module())).into();
        modules.push(add("words", WORDS.to_owned()));
        Self {
            look_up: add("look_up", look_up_module(&ways)),
            _modules: modules,
            ways,
            done: [false; PATCHES.len()],
            failure: None,
        }
    }

    pub(crate) fn state(&self) -> PatchState<'_> {
        match &self.failure {
            Some(error) => PatchState::Failed(error),
            None if self.done == [true; PATCHES.len()] => PatchState::Done,
            None => PatchState::Pending,
        }
    }

    /// Whether the module that calls look-ups has this way.
    pub(crate) fn has_way(&self, way: Way) -> bool {
        self.ways.contains(&way)
    }

    /// Adds ways of looking up to the module that calls them. Pipelines are recompiled.
    pub(crate) fn add_ways(&mut self, more: impl Iterator<Item = Way>, shaders: &mut Assets<Shader>) {
        let mut ways = self.ways.clone();
        ways.extend(more);
        if let Some(mut module) = shaders.get_mut(&self.look_up) {
            *module = Shader::from_wgsl(look_up_module(&ways), module.path.clone());
            self.ways = ways;
        }
    }
}

/// Patches each shader as soon as it is loaded. A shader that changes later, as in a hot reload, is patched
/// again.
pub(crate) fn patch_shaders(
    server: Res<AssetServer>,
    mut shaders: ResMut<Assets<Shader>>,
    mut changes: MessageReader<AssetEvent<Shader>>,
    mut state: ResMut<ShaderPatch>,
) {
    let has_changes = changes.read().any(|event| matches!(event, AssetEvent::Modified { .. }));
    if state.failure.is_some() || (state.done == [true; PATCHES.len()] && !has_changes) {
        return;
    }
    for (n, patch) in PATCHES.iter().enumerate() {
        let Some(handle) = server.get_handle::<Shader>(patch.asset) else { continue };
        let Some(shader) = shaders.get(&handle) else { continue };
        let patched = match &shader.source {
            Source::Wgsl(text) => patch.apply(text),
            _ => Err(BakedShadowError::ShaderLanguage { shader: patch.asset }),
        };
        match patched {
            Ok(None) => state.done[n] = true,
            Ok(Some(text)) => {
                let mut new = Shader::from_wgsl(text, shader.path.clone());
                new.shader_defs = shader.shader_defs.clone();
                new.import_path = shader.import_path.clone();
                if let Some(mut shader) = shaders.get_mut(&handle) {
                    *shader = new;
                }
                state.done[n] = true;
            }
            Err(error) => {
                error!("{error}. All shadows come from cascades");
                state.failure = Some(error);
                return;
            }
        }
    }
}
