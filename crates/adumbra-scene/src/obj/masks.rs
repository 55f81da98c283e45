//! The textures of MTL files: `map_d`, which decides where a surface is opaque, and `map_Kd`, its colour.
//!
//! The value of a mask is the channel that `-imfchan` names. Without that option it is alpha if the image has
//! texels that are not fully opaque, otherwise luminance, because programs write masks in both ways. If the
//! image is also the material's colour, it is not a grey mask, so its alpha is used. Values are used as
//! stored, without gamma.
//!
//! A material has one texture. The mask decides its size and the placing of its coordinates, so that opacity
//! does not depend on whether colours are loaded; the colours are sampled at the mask's texels.

use hashbrown::{HashMap, HashSet};

use crate::obj::files::Files;
use crate::obj::maps::{Channel, Map};
use crate::obj::materials::{Library, Mtl};
use crate::sources::{Located, MAX_IMAGE_BYTES, OUTSIDE};
use crate::{Error, LoadNotes, LoadOptions, Material, Pixels, Result, Texture, Wrap};

/// The sources of a texture. Equal sources give the same texture.
#[derive(Clone, PartialEq, Eq, Hash)]
struct Source {
    mask: Option<MaskSource>,
    color: Option<Located>,
    clamps: bool,
}

/// The source of a mask.
#[derive(Clone, PartialEq, Eq, Hash)]
struct MaskSource {
    file: Located,
    channel: Option<Channel>,
    /// The bits of the base and the gain.
    range: [u32; 2],
}

/// Loads the textures of materials.
pub(super) struct Textures<'t, 'a> {
    files: &'t Files<'a>,
    options: &'t LoadOptions,
    /// `None` for a mask that cuts nothing out.
    loaded: HashMap<Source, Option<u32>>,
    /// Colour textures that cannot be read, each with a warning.
    failed: HashSet<Vec<u8>>,
    textures: Vec<Texture>,
}

impl<'t, 'a> Textures<'t, 'a> {
    pub(super) fn new(files: &'t Files<'a>, options: &'t LoadOptions) -> Self {
        Self { files, options, loaded: HashMap::new(), failed: HashSet::new(), textures: Vec::new() }
    }

    /// Loads the textures of the materials that are `used`.
    ///
    /// # Errors
    /// Returns [`Error::Texture`] or [`Error::OutsideScene`] for a mask that cannot be read; a colour texture
    /// that cannot be read is a warning instead. Returns [`Error::SceneMemory`] if textures exceed the
    /// budget.
    pub(super) fn load(
        mut self,
        library: &Library,
        used: &[bool],
        materials: &mut [Material],
        notes: &mut LoadNotes,
    ) -> Result<Vec<Texture>> {
        for ((mtl, material), _) in library.list.iter().zip(materials).zip(used).filter(|&(_, &used)| used) {
            material.texture = self.load_one(mtl, notes)?;
        }
        Ok(self.textures)
    }

    fn load_one(&mut self, mtl: &Mtl, notes: &mut LoadNotes) -> Result<Option<u32>> {
        let mask = match mtl.wanted_mask(self.options) {
            Some(map) => Some((map, self.mask_source(mtl, map)?)),
            None => None,
        };
        let mut color = match mtl.color.as_deref().filter(|_| self.options.color_textures) {
            Some(map) => self.color_file(mtl, map, notes)?.map(|file| (map, file)),
            None => None,
        };
        if let (Some((mask, _)), Some((map, _))) = (&mask, &color)
            && (mask.placing != map.placing || mask.clamps != map.clamps)
        {
            notes.warnings.push(format!(
                "material {:?}: the colour texture {} is ignored: it is placed differently from the opacity map",
                mtl.name,
                map.shown()
            ));
            color = None;
        }
        let Some(map) = mask.as_ref().map(|m| m.0).or(color.as_ref().map(|c| c.0)) else { return Ok(None) };
        let source = Source {
            mask: mask.as_ref().map(|m| m.1.clone()),
            color: color.as_ref().map(|c| c.1.clone()),
            clamps: map.clamps,
        };
        if let Some(&known) = self.loaded.get(&source) {
            return Ok(known);
        }
        let mask = match &mask {
            Some((map, source)) => Some(self.mask(mtl, map, source)?),
            None => None,
        };
        let color = match &color {
            Some((map, file)) => self.color(mtl, map, file, notes)?,
            None => None,
        };
        let texture = match (mask, color) {
            (Some(mask), Some(color)) => Some(self.combined(mask, &color)?),
            (Some(mask), None) if mask.is_fully_opaque() => {
                self.files.sources.budget.release(mask.memory_bytes() as u64);
                None
            }
            (mask, color) => mask.or(color),
        };
        let index = texture.map(|mut texture| {
            if source.clamps {
                texture.wrap = [Wrap::Clamp; 2];
            }
            self.textures.push(texture);
            self.textures.len() as u32 - 1
        });
        self.loaded.insert(source, index);
        Ok(index)
    }

    fn mask_source(&self, mtl: &Mtl, map: &Map) -> Result<MaskSource> {
        let place = format!("map_d of material {:?}", mtl.name);
        let file = self.files.locate(&place, &map.file_names()).map_err(|e| self.error(mtl, map, e))?;
        let is_color = mtl.color.as_ref().is_some_and(|color| color.is_file_of(map));
        let channel = map.channel.or(is_color.then_some(Channel::Matte));
        Ok(MaskSource { file, channel, range: map.base_and_gain.map(f32::to_bits) })
    }

    /// Converts an error into one about a mask. Errors about memory, files outside the folder and textures
    /// are kept.
    fn error(&self, mtl: &Mtl, map: &Map, e: Error) -> Error {
        match e {
            e @ (Error::SceneMemory { .. } | Error::OutsideScene { .. } | Error::Texture { .. }) => e,
            e => Error::Texture {
                path: self.files.sources.scene.to_owned(),
                material: mtl.name.clone(),
                texture: map.shown(),
                what: e.to_string(),
            },
        }
    }

    /// Reads a mask.
    fn mask(&self, mtl: &Mtl, map: &Map, source: &MaskSource) -> Result<Texture> {
        let broken = |what: String| Error::Texture {
            path: self.files.sources.scene.to_owned(),
            material: mtl.name.clone(),
            texture: map.shown(),
            what,
        };
        if source.channel == Some(Channel::Depth) {
            return Err(broken("-imfchan z asks for a depth channel, which it does not have".to_owned()));
        }
        let place = format!("map_d of material {:?}", mtl.name);
        let image = self.decode(&source.file, &place, map).map_err(|e| self.error(mtl, map, e))?;
        let Texture { name, width, height, pixels, wrap, nearest } = image.map_err(broken)?;
        let rgba = match &pixels {
            Pixels::Rgba(rgba) | Pixels::Alpha(rgba) => rgba.as_chunks::<4>().0,
        };
        let channel = source.channel.unwrap_or_else(|| {
            let has_alpha = rgba.iter().any(|texel| texel[3] != 255);
            if has_alpha { Channel::Matte } else { Channel::Luminance }
        });
        let [base, gain] = source.range.map(f32::from_bits);
        let table: [u8; 256] = std::array::from_fn(|value| {
            let value = base * 255.0 + gain * value as f32;
            // Rounded; values out of range are clamped.
            (value + 0.5) as u8
        });
        let budget = &self.files.sources.budget;
        budget.charge(rgba.len() as u64, || format!("the opacity map {name:?}"))?;
        let values = rgba.iter().map(|&texel| table[usize::from(value(texel, channel))]);
        let alpha: Vec<u8> = values.collect();
        budget.release(4 * alpha.len() as u64);
        Ok(Texture { name, width, height, pixels: Pixels::Alpha(alpha), wrap, nearest })
    }

    /// The file of a colour texture; `None` with a warning if it is not there.
    fn color_file(&mut self, mtl: &Mtl, map: &Map, notes: &mut LoadNotes) -> Result<Option<Located>> {
        let place = format!("map_Kd of material {:?}", mtl.name);
        match self.files.locate(&place, &map.file_names()) {
            Ok(file) => Ok(Some(file)),
            Err(e @ Error::SceneMemory { .. }) => Err(e),
            Err(Error::OutsideScene { .. }) => {
                if self.warn(mtl, map, OUTSIDE, notes) {
                    notes.outside_textures += 1;
                }
                Ok(None)
            }
            Err(e) => {
                self.warn(mtl, map, &e.to_string(), notes);
                Ok(None)
            }
        }
    }

    /// Reads a colour texture; `None` with a warning if it is not valid. It is colour only: opacity must not
    /// depend on whether colours are loaded.
    fn color(
        &mut self,
        mtl: &Mtl,
        map: &Map,
        file: &Located,
        notes: &mut LoadNotes,
    ) -> Result<Option<Texture>> {
        let place = format!("map_Kd of material {:?}", mtl.name);
        let problem = match self.decode(file, &place, map) {
            Ok(Ok(mut texture)) => {
                if let Pixels::Rgba(rgba) = &mut texture.pixels {
                    rgba.as_chunks_mut::<4>().0.iter_mut().for_each(|texel| texel[3] = 255);
                }
                return Ok(Some(texture));
            }
            Ok(Err(what)) => what,
            Err(e @ Error::SceneMemory { .. }) => return Err(e),
            Err(e) => e.to_string(),
        };
        self.warn(mtl, map, &problem, notes);
        Ok(None)
    }

    /// Warns about a colour texture, once for each file. Returns whether it did.
    fn warn(&mut self, mtl: &Mtl, map: &Map, what: &str, notes: &mut LoadNotes) -> bool {
        let names = map.file_names();
        let is_new = self.failed.insert(names.first().copied().unwrap_or_default().to_owned());
        if is_new {
            let (name, file) = (&mtl.name, map.shown());
            notes.warnings.push(format!("material {name:?}: the colour texture {file} is ignored: {what}"));
        }
        is_new
    }

    /// Decodes an image to four channels. The inner error is a clause for a message.
    fn decode(&self, file: &Located, place: &str, map: &Map) -> Result<Result<Texture, String>> {
        let sources = self.files.sources;
        let bytes = sources.read_whole(file, place, MAX_IMAGE_BYTES)?;
        let name = map.shown();
        let ending = name.rsplit_once('.').map_or("", |(_, ending)| ending).to_owned();
        let decoded = Texture::decode(name, &bytes, &ending, false, &sources.budget)?;
        sources.budget.release(bytes.len() as u64);
        Ok(decoded)
    }

    /// The colours of one texture at the texels of the other, with its alpha.
    fn combined(&self, mask: Texture, color: &Texture) -> Result<Texture> {
        let budget = &self.files.sources.budget;
        let (Pixels::Alpha(alpha), Pixels::Rgba(rgba)) = (&mask.pixels, &color.pixels) else {
            return Ok(mask);
        };
        budget.charge(4 * alpha.len() as u64, || format!("the colours and opacity of {:?}", mask.name))?;
        let texels = rgba.as_chunks::<4>().0;
        let [width, height] = [mask.width, mask.height].map(u64::from);
        let nearest = |at: u64, of: u64, size: u32| (at * 2 + 1) * u64::from(size) / (of * 2);
        let mut both = Vec::with_capacity(4 * alpha.len());
        for (index, &a) in (0..).zip(alpha) {
            let x = nearest(index % width, width, color.width);
            let y = nearest(index / width, height, color.height);
            let texel = texels.get((y * u64::from(color.width) + x) as usize);
            let [r, g, b, _] = texel.copied().unwrap_or([255; 4]);
            both.extend_from_slice(&[r, g, b, a]);
        }
        budget.release((alpha.len() + rgba.len()) as u64);
        Ok(Texture { pixels: Pixels::Rgba(both), ..mask })
    }
}

/// The value of a channel. Luminance uses the weights of BT.709 as 256ths, so that a grey value is unchanged.
fn value([r, g, b, a]: [u8; 4], channel: Channel) -> u8 {
    match channel {
        Channel::Red => r,
        Channel::Green => g,
        Channel::Blue => b,
        Channel::Matte => a,
        Channel::Luminance | Channel::Depth => {
            ((54 * u32::from(r) + 183 * u32::from(g) + 19 * u32::from(b) + 128) >> 8) as u8
        }
    }
}
