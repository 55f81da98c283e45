//! The layout of the words of several files in one texture, below a picture or alone.

use bevy::math::UVec2;

use crate::texels::Texels;

/// The layout of words in a texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Layout {
    /// Size of the picture above them; zero without one.
    pub(crate) picture: UVec2,
    /// Narrower files are laid out with this width, a power of two, so that they take fewer rows.
    least_width: u32,
}

impl Default for Layout {
    fn default() -> Self {
        Self { picture: UVec2::ZERO, least_width: 1 }
    }
}

impl Layout {
    /// Returns the layout below a picture, in textures with sides of at most `max_side` texels. `None` if
    /// nothing fits.
    pub(crate) fn below<'t>(
        picture: UVec2,
        files: impl Iterator<Item = &'t Texels> + Clone,
        max_side: u32,
    ) -> Option<Self> {
        let widths = std::iter::successors(Some(1_u32), |width| Some(2 * width).filter(|w| *w <= max_side));
        widths
            .map(|least_width| Self { picture, least_width })
            .find(|layout| layout.size(files.clone()).max_element() <= max_side)
    }

    pub(crate) fn width(&self, texels: &Texels) -> u32 {
        texels.width().max(self.least_width)
    }

    fn rows(&self, texels: &Texels) -> u32 {
        let all = u64::from(texels.width()) * u64::from(texels.height());
        all.div_ceil(self.width(texels).into()) as u32
    }

    /// Returns the first row of each file, counted from the top of the texture.
    pub(crate) fn first_rows<'t>(
        &self,
        files: impl Iterator<Item = &'t Texels>,
    ) -> impl Iterator<Item = u32> {
        let layout = *self;
        files.scan(self.picture.y, move |row, texels| {
            let first = *row;
            *row += layout.rows(texels);
            Some(first)
        })
    }

    /// Returns the number of rows of all files and the directory.
    pub(crate) fn all_rows<'t>(&self, files: impl Iterator<Item = &'t Texels>) -> u32 {
        1 + files.map(|texels| self.rows(texels)).sum::<u32>()
    }

    /// Returns the size of the texture.
    pub(crate) fn size<'t>(&self, files: impl Iterator<Item = &'t Texels> + Clone) -> UVec2 {
        let width = files.clone().map(|texels| self.width(texels)).max().unwrap_or(1);
        UVec2::new(width.max(self.picture.x), self.picture.y + self.all_rows(files))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::texels::PoolTexels;

    #[test]
    fn widens_files_that_would_not_fit_below_a_picture() {
        let all = [4096 * 4096 - 128, 4096 * 4096 - 128, 1000]
            .map(|words| Texels::Pool(PoolTexels::new(words, 8192)));
        let two = Layout::below(UVec2::ZERO, all[1..].iter(), 8192).unwrap();
        assert_eq!((two.least_width, two.size(all[1..].iter())), (1, UVec2::new(4096, 4096 + 9 + 1)));
        // 4096 + 4096 + 9 + 1 rows are more than 8192.
        let large = Layout::below(UVec2::new(3840, 2160), all.iter(), 8192).unwrap();
        assert_eq!(large.least_width, 8192);
        assert_eq!(large.size(all.iter()), UVec2::new(8192, 2160 + 2 * 2048 + 1 + 1));
        let rows: Vec<_> = large.first_rows(all.iter()).collect();
        assert_eq!(rows, [2160, 2160 + 2048, 2160 + 4096]);
        let thrice = || all.iter().chain(&all).chain(&all);
        assert!(Layout::below(UVec2::ZERO, thrice(), 16384).is_some());
        assert_eq!(Layout::below(UVec2::new(3840, 2160), thrice(), 8192), None);
    }
}
