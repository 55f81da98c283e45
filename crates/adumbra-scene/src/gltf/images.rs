//! The images of a glTF scene. Each is read and decoded once, however many image entries, textures and
//! materials use the same bytes.

use std::rc::Rc;

use ::gltf::json::Root;
use ::gltf::json::texture::{MagFilter, Texture as Json, WrappingMode};
use ::gltf::json::validation::Checked;
use hashbrown::HashMap;

use crate::gltf::container::Buffers;
use crate::gltf::numbers::index_of;
use crate::gltf::uris;
use crate::sources::{Located, MAX_IMAGE_BYTES};
use crate::{Error, Result, Texture, Wrap};

/// Why a material's texture was not loaded.
#[derive(Clone, Debug)]
pub(super) enum Problem {
    /// The image is missing or invalid.
    Unreadable {
        /// The image's file, name or index.
        texture: String,
        /// A clause describing the error.
        what: String,
    },
    /// The image is outside the scene's folder.
    Outside {
        /// The part of the scene that references it.
        place: String,
        /// The file name as written in the scene.
        named: String,
    },
}

/// The source of an image's bytes. Images with equal sources are the same image.
#[derive(Clone, PartialEq, Eq, Hash)]
enum Content {
    /// Buffer index, byte offset and length of a buffer view.
    View(usize, u64, u64),
    /// A file next to the scene.
    File(Located),
    /// The bytes of a data URI.
    Data(Vec<u8>),
}

/// A sampler's settings: wrap of both axes, nearest.
type Sampling = ([Wrap; 2], bool);

/// A texture's index; `None` if only alpha is needed and the image is fully opaque.
type Loaded = Result<Option<u32>, Problem>;

/// Loads the images that textures reference.
pub(super) struct Images<'a> {
    root: &'a Root,
    buffers: &'a Buffers<'a>,
    alpha_only: bool,
    contents: Vec<Rc<Content>>,
    known: HashMap<Rc<Content>, usize>,
    /// For each image entry used so far, the index of its content.
    of_image: HashMap<usize, Result<usize, Problem>>,
    /// For each decoded content, its texture.
    decoded: HashMap<usize, Loaded>,
    /// For each content and sampling mode, its texture.
    sampled: HashMap<(usize, Sampling), Loaded>,
}

impl<'a> Images<'a> {
    pub(super) fn new(root: &'a Root, buffers: &'a Buffers<'a>, alpha_only: bool) -> Self {
        Self {
            root,
            buffers,
            alpha_only,
            contents: Vec::new(),
            known: HashMap::new(),
            of_image: HashMap::new(),
            decoded: HashMap::new(),
            sampled: HashMap::new(),
        }
    }

    /// Loads the texture with index `index` in the file, and returns its index in `textures`.
    ///
    /// # Errors
    /// Returns [`Error::SceneMemory`] if it exceeds the memory budget. Other errors of a texture are returned
    /// as a [`Problem`].
    pub(super) fn load(&mut self, index: usize, textures: &mut Vec<Texture>) -> Result<Loaded> {
        let Some(json) = self.root.textures.get(index) else {
            return Ok(Err(unreadable(index.to_string(), "it does not exist")));
        };
        let checked = self.check("texture", index).and_then(|()| match json.sampler {
            Some(sampler) => self.check("sampler", sampler.value()),
            None => Ok(()),
        });
        if let Err(problem) = apart(checked, || index.to_string())? {
            return Ok(Err(problem));
        }
        let image = self.image(json);
        let sampler = json.sampler.and_then(|s| self.root.samplers.get(s.value()));
        let wraps = sampler.map_or([Wrap::Repeat; 2], |s| [wrap(&s.wrap_s), wrap(&s.wrap_t)]);
        let nearest = sampler.is_some_and(|s| s.mag_filter == Some(Checked::Valid(MagFilter::Nearest)));
        let content = match self.content(image)? {
            Ok(content) => content,
            Err(problem) => return Ok(Err(problem)),
        };
        let key = (content, (wraps, nearest));
        if let Some(done) = self.sampled.get(&key) {
            return Ok(done.clone());
        }
        let loaded = match self.decoded.get(&content) {
            Some(Ok(Some(first))) => Ok(Some(self.copy(*first, key.1, textures)?)),
            Some(decoded) => decoded.clone(),
            None => {
                let loaded = self.decode(image, content)?.map(|texture| {
                    let mut texture = texture?;
                    (texture.wrap, texture.nearest) = key.1;
                    textures.push(texture);
                    Some(textures.len() as u32 - 1)
                });
                self.decoded.insert(content, loaded.clone());
                loaded
            }
        };
        self.sampled.insert(key, loaded.clone());
        Ok(loaded)
    }

    /// The image entry of a texture. KTX2 is used only if there is no other image, because it loses detail.
    fn image(&self, texture: &Json) -> usize {
        let named = |extension: &str| {
            let json = texture.extensions.as_ref()?.others.get(extension)?;
            index_of(json.get("source")?)
        };
        let plain = Some(texture.source.value()).filter(|&image| image < self.root.images.len());
        let image = named("EXT_texture_webp").or(plain).or_else(|| named("KHR_texture_basisu"));
        image.unwrap_or(usize::MAX)
    }

    /// Copies a texture for use with another sampler.
    fn copy(&self, first: u32, sampling: Sampling, textures: &mut Vec<Texture>) -> Result<u32> {
        let original = &textures[first as usize];
        let what = || format!("a copy of texture {:?} for another sampler", original.name);
        self.buffers.sources.budget.charge(original.memory_bytes() as u64, what)?;
        let mut copy = original.clone();
        (copy.wrap, copy.nearest) = sampling;
        textures.push(copy);
        Ok(textures.len() as u32 - 1)
    }

    /// The index of an image entry's content.
    fn content(&mut self, image: usize) -> Result<Result<usize, Problem>> {
        if let Some(known) = self.of_image.get(&image) {
            return Ok(known.clone());
        }
        let content = match self.root.images.get(image) {
            None => {
                Err(unreadable("without an image".to_owned(), "it references no image in a supported format"))
            }
            Some(json)
                if json.uri.is_none() && json.buffer_view.is_none() && self.check("image", image).is_ok() =>
            {
                Err(unreadable(self.label(image), "it has no data"))
            }
            Some(_) => apart(self.find(image), || self.label(image))?,
        };
        let content = content.map(|content| {
            let content = Rc::new(content);
            let next = self.contents.len();
            let index = *self.known.entry(content.clone()).or_insert(next);
            if index == next {
                self.contents.push(content);
            }
            index
        });
        self.of_image.insert(image, content.clone());
        Ok(content)
    }

    fn check(&self, kind: &'static str, index: usize) -> Result<()> {
        self.buffers.faults.check(self.buffers.sources.scene, kind, index)
    }

    fn find(&self, image: usize) -> Result<Content> {
        self.check("image", image)?;
        let (sources, json) = (self.buffers.sources, &self.root.images[image]);
        let place = format!("image {image}");
        Ok(match (json.uri.as_deref(), json.buffer_view) {
            (Some(uri), _) => match uri.strip_prefix("data:") {
                Some(data) => Content::Data(uris::read_data(sources, data, &place)?),
                None => Content::File(uris::locate(sources, &place, uri)?),
            },
            (None, Some(view)) => {
                let (_, view) = self.buffers.view(self.root, view.value())?;
                Content::View(view.buffer.value(), view.byte_offset.map_or(0, |o| o.0), view.byte_length.0)
            }
            (None, None) => Content::Data(Vec::new()),
        })
    }

    /// The decoded image; `None` if only alpha is needed and the image is fully opaque.
    fn decode(&self, image: usize, content: usize) -> Result<Result<Option<Texture>, Problem>> {
        let (sources, json) = (self.buffers.sources, &self.root.images[image]);
        let label = || self.label(image);
        let mut read = Vec::new();
        let bytes = match &*self.contents[content] {
            Content::View(..) => match json.buffer_view {
                Some(view) => self.buffers.view(self.root, view.value())?.0,
                None => &[],
            },
            Content::Data(bytes) => bytes,
            Content::File(file) => {
                match apart(sources.read_whole(file, &format!("image {image}"), MAX_IMAGE_BYTES), label)? {
                    Ok(bytes) => read = bytes,
                    Err(problem) => return Ok(Err(problem)),
                }
                &read
            }
        };
        let file = json.uri.as_deref().filter(|u| !u.starts_with("data:"));
        let ending = file.and_then(|f| f.rsplit_once('.')).map_or("", |(_, ending)| ending);
        let decoded = Texture::decode(label(), bytes, ending, self.alpha_only, &sources.budget)?;
        sources.budget.release(read.len() as u64);
        Ok(match decoded {
            Ok(texture) if self.alpha_only && texture.is_fully_opaque() => {
                sources.budget.release(texture.memory_bytes() as u64);
                Ok(None)
            }
            Ok(texture) => Ok(Some(texture)),
            Err(what) => Err(unreadable(label(), &what)),
        })
    }

    /// The image's file, name or index.
    fn label(&self, image: usize) -> String {
        let json = self.root.images.get(image);
        let file = json.and_then(|i| i.uri.as_ref()).filter(|u| !u.starts_with("data:"));
        let named = file.or(json.and_then(|i| i.name.as_ref()));
        named.cloned().unwrap_or_else(|| format!("image {image}"))
    }
}

fn unreadable(texture: String, what: &str) -> Problem {
    Problem::Unreadable { texture, what: what.to_owned() }
}

/// Separates errors that affect only one texture from those that abort the load.
fn apart<T>(result: Result<T>, label: impl FnOnce() -> String) -> Result<Result<T, Problem>> {
    match result {
        Ok(value) => Ok(Ok(value)),
        Err(e @ Error::SceneMemory { .. }) => Err(e),
        Err(Error::OutsideScene { place, named, .. }) => Ok(Err(Problem::Outside { place, named })),
        Err(e) => Ok(Err(Problem::Unreadable { texture: label(), what: e.to_string() })),
    }
}

fn wrap(mode: &Checked<WrappingMode>) -> Wrap {
    match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
        _ => Wrap::Repeat,
    }
}
