//! Sheets of the paper's figures 4 to 7, of foliage, and of the levels.

use adumbra_render::layers::LEVEL_COLORS;
use adumbra_render::{Answer, Given, Prepared, Renderer, Shot, TechniqueFiles, build};
use adumbra_scene::Camera;
use adumbra_truth::picture::Picture;

use super::measure::{hybrid, plain};
use super::models::PlacedModel;
use adumbra_compare::compare::Reference;
use adumbra_compare::pictures::{Cell, picture_of_rgba, sheet};
use adumbra_compare::truth::SunShape;
use adumbra_compare::{Result, layers};

/// Size of one picture of a sheet in pixels.
const SIZE: [u32; 2] = [640, 480];
/// Description of [`LEVEL_COLORS`].
const LEVEL_WORDS: &str = "finest level red, then orange, green, blue";

/// A caption and a sheet.
type Figure = (String, Picture);

/// A model on the device.
pub(super) struct Stage<'a, 'j, 's> {
    pub(super) renderer: &'a mut Renderer,
    pub(super) reference: &'a Reference<'j, 's>,
    pub(super) standing: &'a PlacedModel,
}

/// The content of a picture.
enum Show {
    Technique(String),
    Truth,
    Levels(String),
}

impl Stage<'_, '_, '_> {
    /// Draws the figures in which a model appears. Returns each name with the picture or the error that
    /// prevented it.
    pub(super) fn figures(&mut self, model: &str) -> Vec<(&'static str, Result<Figure>)> {
        match model {
            "dragon" => vec![
                ("hrsm-figure-4", self.outlines()),
                ("hrsm-figure-6", self.self_shadow()),
                ("hrsm-figure-7", self.starts()),
            ],
            "wires" => vec![("hrsm-figure-5", self.thin())],
            "oak" => vec![("hrsm-foliage", self.foliage())],
            _ => Vec::new(),
        }
    }

    fn outlines(&mut self) -> Result<Figure> {
        let camera = self.outline();
        let pairs = [(1024, 2048), (512, 1024), (2048, 4096)];
        let shows = pairs.into_iter().flat_map(|(size, start)| {
            [Show::Technique(plain(size, 1)), Show::Technique(hybrid(start, size, 1))]
        });
        let picture = self.sheet(&camera, shows, 2)?;
        let caption = "The paper's figure 4: the outline of the Dragon's shadow at equal TARGET, SM on the left and HRSM on the right, unfiltered.";
        Ok((caption.to_owned(), picture))
    }

    fn thin(&mut self) -> Result<Figure> {
        let cameras = [
            self.standing.part([0.5, 0.1, 0.5], [-0.42, 0.45, 0.66], 0.8, SIZE),
            self.standing.part([0.55, 0.0, 0.5], [-0.2, 0.9, 0.3], 0.45, SIZE),
        ];
        let mut cells = Vec::new();
        for camera in &cameras {
            for name in [plain(2048, 1), hybrid(4096, 2048, 1)] {
                cells.push((self.show(camera, &Show::Technique(name.clone()))?, vec![name]));
            }
        }
        let caption = "The paper's figure 5: thin casters, SM on the left and HRSM on the right, unfiltered.";
        Ok((caption.to_owned(), together(&cells, 2)))
    }

    fn self_shadow(&mut self) -> Result<Figure> {
        let camera = self.standing.part([0.45, 0.55, 0.5], [0.1, 0.45, 0.9], 0.55, SIZE);
        let name = hybrid(2048, 1024, 1);
        let paper = format!("{name}:test=paper");
        let shows =
            [Show::Technique(name), Show::Truth, Show::Technique(paper), Show::Technique(plain(1024, 1))];
        let caption = "The paper's figure 6: self-shadowing. HRSM with the plane test, rays, HRSM with the paper's test, and SM at TARGET.";
        Ok((caption.to_owned(), self.sheet(&camera, shows, 2)?))
    }

    fn starts(&mut self) -> Result<Figure> {
        let camera = self.outline();
        let mut shows = vec![Show::Technique(plain(512, 1))];
        shows.extend([1024, 2048, 4096].map(|start| Show::Technique(hybrid(start, 512, 1))));
        let caption = "The paper's figure 7: TARGET 512 with increasing START, unfiltered.";
        Ok((caption.to_owned(), self.sheet(&camera, shows, 2)?))
    }

    fn foliage(&mut self) -> Result<Figure> {
        let camera = self.standing.outline(self.reference.towards_sun, 0.45, SIZE);
        let name = hybrid(4096, 1024, 1);
        let shows =
            [Show::Technique(plain(4096, 1)), Show::Technique(name.clone()), Show::Levels(name), Show::Truth];
        let caption = format!(
            "Foliage, which the paper names as its failure: few texels merge within the tree and its shadow. SM, HRSM, its levels ({LEVEL_WORDS}), and rays."
        );
        Ok((caption, self.sheet(&camera, shows, 2)?))
    }

    /// Returns a camera on the shadow's outline away from the sun.
    fn outline(&self) -> Camera {
        self.standing.outline(self.reference.towards_sun, 0.25, SIZE)
    }

    fn sheet(
        &mut self,
        camera: &Camera,
        shows: impl IntoIterator<Item = Show>,
        columns: usize,
    ) -> Result<Picture> {
        let mut cells = Vec::new();
        for show in shows {
            let caption = match &show {
                Show::Technique(name) => name.clone(),
                Show::Truth => "rays".to_owned(),
                Show::Levels(name) => format!("{name}, levels"),
            };
            cells.push((self.show(camera, &show)?, vec![caption]));
        }
        Ok(together(&cells, columns))
    }

    fn show(&mut self, camera: &Camera, show: &Show) -> Result<Picture> {
        let shot = Shot { camera: *camera, towards_sun: self.reference.towards_sun, number: 0 };
        let size = [camera.width, camera.height];
        let mut prepared = match show {
            Show::Technique(name) | Show::Levels(name) => self.prepare(name)?,
            Show::Truth => self.truth(camera)?,
        };
        self.renderer.draw(&shot, &mut prepared, Answer::Visibility)?;
        let rgba = self.renderer.read_picture()?;
        if let Show::Levels(_) = show {
            self.renderer.draw(&shot, &mut prepared, Answer::Level)?;
            let levels = self.renderer.read_factor(&prepared)?;
            return Ok(layers::tinted(size, &rgba, levels, &LEVEL_COLORS).picture());
        }
        Ok(picture_of_rgba(size, &rgba))
    }

    fn prepare(&self, name: &str) -> Result<Prepared> {
        let built = build(self.renderer.gpu(), &name.parse()?, TechniqueFiles::default())?;
        Ok(self.renderer.prepare(built)?)
    }

    fn truth(&self, camera: &Camera) -> Result<Prepared> {
        let Reference { truth, cache, scene, towards_sun, .. } = *self.reference;
        let surfaces = cache.surfaces(truth, scene, camera);
        let factors = cache.factors(truth, scene, camera, &surfaces, towards_sun, SunShape::Hard);
        let size = [camera.width, camera.height];
        let given = Given::new(self.renderer.gpu(), "truth", size, &factors)?;
        Ok(self.renderer.prepare(Box::new(given))?)
    }
}

/// The levels of every model.
#[derive(Default)]
pub(super) struct Levels {
    cells: Vec<(Picture, Vec<String>)>,
}

impl Levels {
    /// Draws a model's levels, from `start` over three merges.
    pub(super) fn add(&mut self, stage: &mut Stage<'_, '_, '_>, title: &str, start: u32) -> Result<()> {
        let camera = stage.standing.whole(stage.reference.towards_sun, SIZE);
        let name = hybrid(start, start / 8, 1);
        let caption = vec![format!("{title}, {start}-{}", start / 8)];
        self.cells.push((stage.show(&camera, &Show::Levels(name))?, caption));
        Ok(())
    }

    /// Returns a sheet of all levels with its caption, or `None` if there are none.
    pub(super) fn sheet(&self) -> Option<(Picture, String)> {
        let caption = format!("Levels at which look-ups end, with three merges: {LEVEL_WORDS}.");
        (!self.cells.is_empty()).then(|| (together(&self.cells, 2), caption))
    }
}

fn together(cells: &[(Picture, Vec<String>)], columns: usize) -> Picture {
    let cells: Vec<Cell<'_>> =
        cells.iter().map(|(picture, caption)| Cell { picture, caption: caption.clone() }).collect();
    sheet(&cells, columns, SIZE[0])
}
