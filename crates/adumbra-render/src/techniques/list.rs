//! Lists of shadow techniques, and a technique chosen from one: its entry and its parameters, all of which
//! are known to exist. All other code asks the entry and never compares names.

use std::fmt;

use super::baked::TechniqueFiles;
use super::traits::{Reads, Traits, Truth};
use crate::error::{RenderError, Result};
use crate::gpu::Gpu;
use crate::technique::{Parameter, ParameterKind, SpecReader, SpecText, Technique, changed};

/// How a technique is read from text and built.
pub trait Design: fmt::Debug + Sync {
    /// Returns the properties that are known without a device.
    fn traits(&self, _spec: &TechniqueSpec) -> Traits {
        Traits::DRAWN
    }

    /// Reads the parameters, which validates them and records what they accept. Defaults that depend on a
    /// file, such as the bias, come from `baked`; without a file they are those of a default bake.
    ///
    /// # Errors
    /// Returns [`RenderError::Technique`] for a value that does not exist.
    fn read(&self, reader: &mut SpecReader<'_>, baked: TechniqueFiles<'_>) -> Result<()>;

    /// Builds the technique.
    ///
    /// # Errors
    /// Returns [`RenderError::Technique`] if a file is missing, and an error if the device cannot hold the
    /// technique's resources.
    fn build(&self, gpu: &Gpu, spec: &TechniqueSpec, baked: TechniqueFiles<'_>)
    -> Result<Box<dyn Technique>>;
}

/// The role of a technique in a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It draws shadows.
    Shadows,
    /// It draws shadows, by cascaded shadow maps alone.
    Cascades,
    /// It blurs the factor of another technique on the screen.
    Blur,
    /// It draws no shadows: a reference.
    NoShadows,
    /// Rays on the CPU, whose factors the renderer receives from outside: a reference. See [`crate::Given`].
    Rays,
}

/// An entry of a list of techniques.
#[derive(Debug)]
pub struct TechniqueEntry {
    /// The technique's name.
    pub name: &'static str,
    /// Summary in one line.
    pub summary: &'static str,
    /// Its role in a comparison.
    pub role: Role,
    /// How it is read and built.
    pub design: &'static dyn Design,
}

impl TechniqueEntry {
    /// Whether it is a reference that others are measured against (no shadows, or ray tracing), not a shadow
    /// technique.
    pub fn is_reference(&self) -> bool {
        matches!(self.role, Role::NoShadows | Role::Rays)
    }

    /// Whether its factors are ray-traced on the CPU, so that [`build`] cannot build it.
    pub fn is_traced(&self) -> bool {
        self.role == Role::Rays
    }

    /// Whether its factor can be blurred in screen space.
    pub fn can_be_blurred(&self) -> bool {
        !matches!(self.role, Role::Blur | Role::Rays)
    }
}

/// The techniques that a program offers. [`Techniques::product`] returns the techniques of this crate;
/// [`Techniques::with`] adds techniques of another crate.
#[derive(Clone, Copy, Debug)]
pub struct Techniques {
    product: &'static [TechniqueEntry],
    more: &'static [TechniqueEntry],
}

impl Techniques {
    pub(super) const fn of(product: &'static [TechniqueEntry]) -> Self {
        Self { product, more: &[] }
    }

    /// Returns these techniques with `more` after them. Names must not repeat.
    #[must_use]
    pub const fn with(self, more: &'static [TechniqueEntry]) -> Self {
        Self { more, ..self }
    }

    /// Returns every technique.
    pub fn iter(self) -> impl Iterator<Item = &'static TechniqueEntry> {
        self.product.iter().chain(self.more)
    }

    /// Parses a technique: `NAME[:key=value…]`.
    ///
    /// # Errors
    /// Returns [`RenderError::Technique`] for a name, parameter or value that does not exist, also within a
    /// parameter that is a technique itself, such as the `base` of `blur`.
    pub fn parse(self, text: &str) -> Result<TechniqueSpec> {
        let text: SpecText = text.parse()?;
        let Some(entry) = self.iter().find(|entry| entry.name == text.name()) else {
            let names: Vec<&str> = self.iter().map(|entry| entry.name).collect();
            return Err(text.wrong(format!("unknown technique; choose one of: {}", names.join(", "))));
        };
        let mut reader = text.reader();
        entry.design.read(&mut reader, TechniqueFiles::default())?;
        let parameters = reader.finish()?;
        let base = parameters.iter().find(|p| p.kind == ParameterKind::Technique { of: None });
        let base = match base.map(Parameter::nested).transpose()?.flatten() {
            Some(base) => Some(Box::new(self.parse(&base.to_string())?)),
            None => None,
        };
        if let Some(base) = base.as_ref().filter(|base| !base.entry.can_be_blurred()) {
            return Err(text.wrong(format!("base: {} cannot be blurred", base.name())));
        }
        Ok(TechniqueSpec { text, entry, base, techniques: self })
    }
}

/// A technique of a list, with the parameters that were given.
#[derive(Clone, Debug)]
pub struct TechniqueSpec {
    text: SpecText,
    entry: &'static TechniqueEntry,
    /// The technique whose factor it blurs.
    base: Option<Box<TechniqueSpec>>,
    techniques: Techniques,
}

/// Techniques are equal if their texts are.
impl PartialEq for TechniqueSpec {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

impl fmt::Display for TechniqueSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.text.fmt(f)
    }
}

impl TechniqueSpec {
    /// The technique's name.
    pub fn name(&self) -> &'static str {
        self.entry.name
    }

    /// Name and parameters as text.
    pub fn text(&self) -> &SpecText {
        &self.text
    }

    /// The technique whose factor it blurs, if it is a blur.
    pub fn base(&self) -> Option<&Self> {
        self.base.as_deref()
    }

    /// The list that it was chosen from.
    pub fn techniques(&self) -> Techniques {
        self.techniques
    }

    /// Returns the parameters that apply to the technique with these values. If one of them has another word
    /// as its value, other parameters may apply. Defaults that depend on a file, such as the bias, come from
    /// `baked`; without a file they are those of a default bake. A nested technique, such as the `base` of
    /// `blur`, counts as one parameter: [`Parameter::nested`].
    ///
    /// # Errors
    /// Returns [`RenderError::Technique`] for a parameter or value that the file does not allow.
    pub fn describe(&self, baked: TechniqueFiles<'_>) -> Result<Vec<Parameter>> {
        let mut reader = self.text.reader();
        self.entry.design.read(&mut reader, baked)?;
        if let Some(base) = &self.base {
            base.describe(baked)?;
        }
        reader.finish()
    }

    /// Returns this technique with one parameter changed. Parameters that no longer apply or have their
    /// default value are omitted: `voxel:soft:sun-degrees=2` with `shade=hard` becomes `voxel`.
    ///
    /// # Errors
    /// Returns [`RenderError::Technique`] for a parameter or value that does not exist.
    pub fn change(&self, baked: TechniqueFiles<'_>, key: &str, value: &str) -> Result<Self> {
        let text = changed(&self.text, key, value, |reader| self.entry.design.read(reader, baked))?;
        self.techniques.parse(&text.to_string())
    }

    /// Returns this technique with a parameter set to another value, or removed for `None`. Its text has the
    /// parameters sorted by key.
    ///
    /// # Errors
    /// Returns the errors of [`Techniques::parse`].
    pub fn with(&self, key: &str, value: Option<&str>) -> Result<Self> {
        self.techniques.parse(&self.text.with(key, value).to_string())
    }

    /// The baked file that the technique reads.
    pub fn reads(&self) -> Reads {
        self.traits().reads
    }

    /// The truth that the technique is compared with.
    pub fn truth(&self) -> Truth {
        self.traits().truth
    }

    /// Whether movers cast shadows, as static objects do.
    pub fn shows_movers(&self) -> bool {
        self.traits().shows_movers
    }

    /// [`TechniqueEntry::is_traced`].
    pub fn is_traced(&self) -> bool {
        self.entry.is_traced()
    }

    /// Whether the technique consists of cascaded shadow maps alone.
    pub fn is_cascades(&self) -> bool {
        self.entry.role == Role::Cascades
    }

    /// Properties that are known without a device.
    pub fn traits(&self) -> Traits {
        self.entry.design.traits(self)
    }

    /// Returns this technique with the sun's full angle set, if it has that parameter and does not set it
    /// already. For a blur, the angle is set on its base.
    pub fn with_sun_degrees(&self, degrees: f64) -> Self {
        if !self.traits().takes_sun_degrees {
            return self.clone();
        }
        if let Some(base) = &self.base {
            let base = base.with_sun_degrees(degrees);
            let text = self.text.with("base", Some(&base.to_string()));
            return Self { text, base: Some(Box::new(base)), ..self.clone() };
        }
        if self.text.value("sun-degrees").is_some() {
            return self.clone();
        }
        Self { text: self.text.extended("sun-degrees", &degrees.to_string()), ..self.clone() }
    }

    /// Returns an error about this technique.
    pub fn wrong(&self, reason: String) -> RenderError {
        self.text.wrong(reason)
    }
}

/// Builds a technique on a device.
///
/// # Errors
/// Returns the errors of [`Design::build`].
pub fn build(gpu: &Gpu, spec: &TechniqueSpec, baked: TechniqueFiles<'_>) -> Result<Box<dyn Technique>> {
    spec.entry.design.build(gpu, spec, baked)
}
