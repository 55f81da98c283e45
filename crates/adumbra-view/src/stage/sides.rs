//! A side of the view: its technique, built when it changes, and its picture.

use std::sync::Arc;

use adumbra::format::{AnyFile, ShadowFile, TreeFile};
use adumbra_render::layers::{Layer, LayerPass, ShownPicture};
use adumbra_render::{
    Baked, FrameTimes, Given, Gpu, Prepared, RenderError, Renderer, Result, Shot, TechniqueSpec, build,
};

use crate::shadow_file::lacks_penumbrae;
use crate::tracing::{TraceKey, Traced};

/// At most one shadow file of each kind.
#[derive(Clone, Default)]
pub(crate) struct Files {
    pub(crate) light: Option<Arc<AnyFile>>,
    pub(crate) tree: Option<Arc<AnyFile>>,
}

impl Files {
    /// As techniques take them.
    pub(crate) fn baked(&self) -> Baked<'_> {
        Baked { light: self.light_file(), tree: self.tree_file() }
    }

    fn light_file(&self) -> Option<&ShadowFile> {
        match self.light.as_deref() {
            Some(AnyFile::Light(file)) => Some(file),
            _ => None,
        }
    }

    fn tree_file(&self) -> Option<&TreeFile> {
        match self.tree.as_deref() {
            Some(AnyFile::Tree(file)) => Some(file),
            _ => None,
        }
    }

    /// The file that a technique looks up in; none that lacks what it asks for.
    pub(crate) fn of(&self, spec: &TechniqueSpec) -> Option<&AnyFile> {
        match spec.innermost().name() {
            "voxel" | "voxel+csm" => {
                self.light.as_deref().filter(|file| !spec.needs_hierarchy() || !lacks_penumbrae(file))
            }
            "voxel-cubes" | "voxel-texture" => self.tree.as_deref(),
            _ => None,
        }
    }
}

/// Whether a technique looks up in a file.
pub(crate) fn needs_file(spec: &TechniqueSpec) -> bool {
    spec.innermost().name().starts_with("voxel")
}

/// A side.
pub(crate) struct SideView {
    gpu: Gpu,
    picture: ShownPicture,
    /// What `prepared` is of.
    built: Option<TechniqueSpec>,
    given: Option<TraceKey>,
    prepared: Option<Prepared>,
    /// Drawn in place of what is not there.
    nothing: Option<Prepared>,
    /// What is to be said of it: why it is not there, or what it had to leave out.
    note: Option<String>,
    /// Why it is not there, until it was told.
    fault: Option<String>,
    /// Pixels of the frame that it failed at: at others it is tried again.
    failed_at: Option<[u32; 2]>,
    times: FrameTimes,
}

impl SideView {
    pub(super) fn new(gpu: &Gpu) -> Result<Self> {
        Ok(Self {
            picture: ShownPicture::new(gpu, [1, 1])?,
            gpu: gpu.clone(),
            built: None,
            given: None,
            prepared: None,
            nothing: None,
            note: None,
            fault: None,
            failed_at: None,
            times: FrameTimes::default(),
        })
    }

    pub(super) fn picture(&self) -> &ShownPicture {
        &self.picture
    }

    /// Times of the frame drawn last.
    pub(crate) fn times(&self) -> &FrameTimes {
        &self.times
    }

    /// Bytes that the technique holds on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.prepared.as_ref().map_or(0, |p| p.technique().bytes())
    }

    /// Edge of the finest voxels that it looks up in, world units.
    pub(crate) fn voxel_world(&self) -> Option<f64> {
        self.prepared.as_ref().and_then(|p| p.technique().voxel_world())
    }

    pub(crate) fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// Why it cannot be drawn, where it cannot.
    pub(super) fn failure(&self) -> Option<&str> {
        self.failed_at.and(self.note.as_deref())
    }

    pub(super) fn forget_file(&mut self) {
        if self.built.as_ref().is_some_and(needs_file) {
            self.built = None;
        }
    }

    /// Builds what is not built, of the size that is shown.
    pub(super) fn prepare(
        &mut self,
        renderer: &Renderer,
        spec: &TechniqueSpec,
        files: &Files,
        traced: Option<&Traced>,
        size: [u32; 2],
        samples: u32,
    ) -> Result<()> {
        let fine = size.map(|s| s * samples);
        if self.picture.size() != size {
            self.picture = ShownPicture::new(&self.gpu, size)?;
        }
        if self.nothing.is_none() {
            self.nothing = Some(renderer.prepare(build(&self.gpu, &"none".parse()?, Baked::default())?)?);
        }
        if spec.name() == "truth" {
            return self.prepare_truth(renderer, spec, traced);
        }
        if self.built.as_ref() == Some(spec) && (self.failed_at.is_none() || self.failed_at == Some(fine)) {
            return Ok(());
        }
        (self.prepared, self.given, self.note, self.failed_at) = (None, None, None, None);
        self.built = Some(spec.clone());
        if needs_file(spec) && files.of(spec).is_none() {
            self.note = Some("its shadow file is not there yet".to_owned());
            return Ok(());
        }
        match build(&self.gpu, spec, files.baked()).and_then(|t| renderer.prepare(t)) {
            Ok(prepared) => {
                let notes = prepared.technique().notes();
                self.note = (!notes.is_empty()).then(|| notes.join("; "));
                self.prepared = Some(prepared);
                Ok(())
            }
            Err(error) => self.without(error, fine),
        }
    }

    fn prepare_truth(
        &mut self,
        renderer: &Renderer,
        spec: &TechniqueSpec,
        traced: Option<&Traced>,
    ) -> Result<()> {
        let found = traced.and_then(|t| Some((t.key, t.sun.as_ref()?)));
        let key = found.map(|(key, _)| key);
        if self.built.as_ref() == Some(spec) && self.given == key {
            return Ok(());
        }
        self.built = Some(spec.clone());
        self.given = key;
        (self.prepared, self.note) = (None, None);
        let Some((key, factors)) = found else {
            self.note = Some("rays are traced".to_owned());
            return Ok(());
        };
        let given = Given::new(&self.gpu, "truth", [key.camera.width, key.camera.height], factors)?;
        self.prepared = Some(renderer.prepare(Box::new(given))?);
        Ok(())
    }

    /// Goes on without the technique in frames of this size; a device that is gone is passed on.
    fn without(&mut self, error: RenderError, fine: [u32; 2]) -> Result<()> {
        if super::is_fatal(&error) {
            return Err(error);
        }
        self.prepared = None;
        self.failed_at = Some(fine);
        self.note = Some(error.to_string());
        self.fault = self.note.clone();
        Ok(())
    }

    /// What went wrong since this was asked last.
    pub(crate) fn take_fault(&mut self) -> Option<String> {
        self.fault.take()
    }

    /// Draws a layer of it; the finished picture where it does not have that layer.
    pub(super) fn draw(
        &mut self,
        renderer: &mut Renderer,
        shot: &Shot,
        (layer, samples): (Layer, u32),
        pass: &LayerPass,
    ) -> Result<()> {
        let layer = if self.missing(layer).is_some() { Layer::Color } else { layer };
        if let Some(prepared) = &mut self.prepared {
            match renderer.draw_layer(shot, prepared, (layer, samples), pass, &mut self.picture) {
                Ok(times) => {
                    self.times = times;
                    return Ok(());
                }
                Err(error) => self.without(error, self.picture.size().map(|s| s * samples))?,
            }
        }
        let Some(nothing) = &mut self.nothing else { return Ok(()) };
        let layer = if layer.tint().is_some() { Layer::Color } else { layer };
        self.times = renderer.draw_layer(shot, nothing, (layer, samples), pass, &mut self.picture)?;
        Ok(())
    }

    /// Why it has no such layer, where it has none.
    pub(super) fn missing(&self, layer: Layer) -> Option<String> {
        let (answer, _) = layer.tint()?;
        let prepared = self.prepared.as_ref()?;
        prepared.technique().sources(answer).is_none().then(|| {
            let name = prepared.technique().name();
            format!("{name} has no layer {}", layer.name())
        })
    }
}
