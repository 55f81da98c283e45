//! One side of the view: its technique, rebuilt when it changes, and its picture.

use adumbra_render::layers::{Layer, LayerPass, ShownPicture};
use adumbra_render::{
    FrameTimes, Given, Gpu, Prepared, Reads, RenderError, Renderer, Result, Shot, TechniqueFiles,
    TechniqueSpec, build,
};

use crate::shadow_file::ShownFile;
use crate::traced::{TraceKey, Traced};

/// One side of the view.
pub(crate) struct SideView {
    gpu: Gpu,
    picture: ShownPicture,
    /// The technique from which `prepared` was built.
    built: Option<TechniqueSpec>,
    given: Option<TraceKey>,
    prepared: Option<Prepared>,
    /// Drawn if the technique is unavailable.
    nothing: Option<Prepared>,
    /// Note on the technique: why it is unavailable, or what it had to omit.
    note: Option<String>,
    /// Why it is unavailable, until that was reported.
    fault: Option<String>,
    /// Frame size in pixels at which it failed. It is tried again at other sizes.
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

    /// Returns the times of the last frame.
    pub(crate) fn times(&self) -> &FrameTimes {
        &self.times
    }

    /// Returns the bytes that the technique occupies on the device.
    pub(crate) fn bytes(&self) -> u64 {
        self.prepared.as_ref().map_or(0, |p| p.technique().bytes())
    }

    /// Side length of the finest voxels that the technique reads, in world units.
    pub(crate) fn voxel_world(&self) -> Option<f64> {
        self.prepared.as_ref().and_then(|p| p.technique().voxel_world())
    }

    pub(crate) fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// Returns why the technique cannot be drawn, if it cannot.
    pub(super) fn failure(&self) -> Option<&str> {
        self.failed_at.and(self.note.as_deref())
    }

    pub(super) fn forget_file(&mut self) {
        if self.built.as_ref().is_some_and(|spec| spec.reads() == Reads::LightFile) {
            self.built = None;
        }
    }

    /// Builds whatever is missing, for the size that is shown.
    pub(super) fn prepare(
        &mut self,
        renderer: &Renderer,
        spec: &TechniqueSpec,
        file: Option<&ShownFile>,
        traced: Option<&Traced>,
        size: [u32; 2],
        samples: u32,
    ) -> Result<()> {
        let fine = size.map(|s| s * samples);
        if self.picture.size() != size {
            self.picture = ShownPicture::new(&self.gpu, size)?;
        }
        if self.nothing.is_none() {
            self.nothing =
                Some(renderer.prepare(build(&self.gpu, &"none".parse()?, TechniqueFiles::default())?)?);
        }
        if spec.is_traced() {
            return self.prepare_truth(renderer, spec, traced);
        }
        if self.built.as_ref() == Some(spec) && (self.failed_at.is_none() || self.failed_at == Some(fine)) {
            return Ok(());
        }
        (self.prepared, self.given, self.note, self.failed_at) = (None, None, None, None);
        self.built = Some(spec.clone());
        if spec.reads() == Reads::LightFile && file.is_none() {
            self.note = Some("its shadow file is not ready yet".to_owned());
            return Ok(());
        }
        let baked = file.map(ShownFile::baked).unwrap_or_default();
        match build(&self.gpu, spec, baked).and_then(|t| renderer.prepare(t)) {
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
            self.note = Some("tracing rays".to_owned());
            return Ok(());
        };
        let given = Given::new(&self.gpu, "truth", [key.camera.width, key.camera.height], factors)?;
        self.prepared = Some(renderer.prepare(Box::new(given))?);
        Ok(())
    }

    /// Continues without the technique in frames of this size. The loss of the device is returned as an
    /// error.
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

    /// Returns the fault that occurred since the last call.
    pub(crate) fn take_fault(&mut self) -> Option<String> {
        self.fault.take()
    }

    /// Draws a layer of the side, or the finished picture if the side does not have that layer.
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

    /// Returns why the side lacks a layer, if it does.
    pub(super) fn missing(&self, layer: Layer) -> Option<String> {
        let (answer, _) = layer.tint()?;
        let prepared = self.prepared.as_ref()?;
        prepared.technique().sources(answer).is_none().then(|| {
            let name = prepared.technique().name();
            format!("{name} has no layer {}", layer.name())
        })
    }
}
