//! Scenes made from rasters of heights.

use crate::{Error, Result, Scene, UpAxis, from_triangles};

/// What a raster of heights describes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HeightSurface {
    /// Each cell is level, with upright walls on the borders between cells.
    Blocks,
    /// A surface through the centres of the cells.
    Centres,
}

/// A raster of heights. The rows go south, the columns east.
#[derive(Clone, Copy, Debug)]
pub struct Heights<'a> {
    /// The heights row by row. NaN is a cell without data, in which there is nothing.
    pub heights: &'a [f64],
    /// Numbers of columns and rows.
    pub size: [usize; 2],
    /// Side of a cell, in the unit of the heights.
    pub cell: f64,
    /// The raster's northwest corner, in that unit: x and y where Z points up, x and z where Y points up.
    pub corner: [f64; 2],
    /// What the heights describe.
    pub surface: HeightSurface,
}

/// Most cells of a raster. A cell has at most twelve vertices: four of its top, and eight below walls.
const MOST_CELLS: usize = u32::MAX as usize / 12;

/// Creates a scene of one opaque mesh from a raster of heights. Walls at the raster's border and beside cells
/// without data go down to the lowest height. Where four cells meet, walls of different heights share an
/// edge, not its ends. Errors name `name` in place of a file. Cost: about 500 bytes of memory per cell.
///
/// # Errors
/// Returns [`Error::Raster`] if the size is not that of the heights, a number is not finite, the cell is not
/// above 0 or there is nothing to make a surface of, and the errors of [`from_triangles`].
pub fn from_heights(name: &str, raster: &Heights<'_>, up: UpAxis) -> Result<Scene> {
    if let Some(what) = fault(raster) {
        return Err(Error::Raster { name: name.to_owned(), what });
    }
    let mut mesh = RasterMesh { raster, up, vertices: Vec::new(), triangles: Vec::new() };
    match raster.surface {
        HeightSurface::Blocks => mesh.add_blocks(),
        HeightSurface::Centres => mesh.add_surface(),
    }
    from_triangles(name, &mesh.vertices, &mesh.triangles, &[], up)
}

/// Returns what is wrong with a raster, and what to do.
fn fault(raster: &Heights<'_>) -> Option<String> {
    let Heights { heights, size: [columns, rows], cell, corner, surface } = *raster;
    let cells = heights.len();
    if columns.checked_mul(rows) != Some(cells) {
        return Some(format!(
            "{cells} heights for {columns} columns and {rows} rows; give one for each cell"
        ));
    }
    if cells > MOST_CELLS {
        return Some(format!("{cells} cells, and at most {MOST_CELLS} are possible; cut it into tiles"));
    }
    if !(cell > 0.0 && cell.is_finite()) {
        return Some(format!("cells with a side of {cell}; give a length above 0"));
    }
    if !corner.iter().all(|c| c.is_finite()) {
        return Some(format!("a corner at {corner:?}; give finite coordinates"));
    }
    if let Some(at) = heights.iter().position(|height| height.is_infinite()) {
        let (row, column) = (at / columns, at % columns);
        return Some(format!(
            "an infinite height in row {row}, column {column}; mark cells without data by NaN"
        ));
    }
    if heights.iter().all(|height| height.is_nan()) {
        return Some("no cell with data".to_owned());
    }
    if surface == HeightSurface::Centres && (columns < 2 || rows < 2) {
        let what = "too few to span a surface through their centres; give two rows and two columns";
        return Some(format!("{columns} columns and {rows} rows, {what}"));
    }
    None
}

struct RasterMesh<'a> {
    raster: &'a Heights<'a>,
    up: UpAxis,
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
}

impl RasterMesh<'_> {
    /// Returns the height of a cell, if it has data.
    fn height(&self, at: usize) -> Option<f64> {
        Some(self.raster.heights[at]).filter(|height| !height.is_nan())
    }

    /// Adds a vertex at a distance from the northwest corner, in cells, and returns its number.
    fn vertex(&mut self, [east, south]: [f64; 2], height: f64) -> u32 {
        let Heights { cell, corner: [x, y], .. } = *self.raster;
        let (x, off) = (x + east * cell, south * cell);
        self.vertices.push(match self.up {
            UpAxis::Y => [x, height, y + off],
            UpAxis::Z => [x, y - off, height],
        });
        (self.vertices.len() - 1) as u32
    }

    /// Adds two triangles, for corners that are counterclockwise as seen from outside.
    fn quad(&mut self, [a, b, c, d]: [u32; 4]) {
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    fn add_blocks(&mut self) {
        let [columns, rows] = self.raster.size;
        self.vertices.reserve(4 * columns * rows);
        self.triangles.reserve(2 * columns * rows);
        let least = self.raster.heights.iter().copied().fold(f64::INFINITY, f64::min);
        // The corners of each cell with data, counterclockwise from the northwest.
        let mut tops = vec![None; columns * rows];
        for (at, top) in tops.iter_mut().enumerate() {
            let (column, row) = (at % columns, at / columns);
            let Some(height) = self.height(at) else { continue };
            let [west, north] = [column as f64, row as f64];
            let corners =
                [[west, north], [west, north + 1.0], [west + 1.0, north + 1.0], [west + 1.0, north]];
            let corners = corners.map(|corner| self.vertex(corner, height));
            self.quad(corners);
            *top = Some(corners);
        }
        for at in 0..tops.len() {
            let Some(own) = tops[at] else { continue };
            let (column, row) = (at % columns, at / columns);
            let sides = [
                (column.checked_sub(1).map(|west| [west, row]), [0, 1], [3, 2]),
                (Some([column, row + 1]), [1, 2], [0, 3]),
                (Some([column + 1, row]), [2, 3], [1, 0]),
                (row.checked_sub(1).map(|north| [column, north]), [3, 0], [2, 1]),
            ];
            for (beside, side, opposite) in sides {
                let beside = beside.filter(|&[column, row]| column < columns && row < rows);
                let other = beside.and_then(|[column, row]| tops[row * columns + column]);
                self.add_wall(
                    side.map(|corner| own[corner]),
                    other.map(|top| opposite.map(|c| top[c])),
                    least,
                );
            }
        }
    }

    /// Adds the wall below an edge of a cell, down to the edge of the lower cell beside it, or to the lowest
    /// height.
    fn add_wall(&mut self, [a, b]: [u32; 2], below: Option<[u32; 2]>, least: f64) {
        let height_axis = if self.up == UpAxis::Y { 1 } else { 2 };
        let height = |mesh: &Self, vertex: u32| mesh.vertices[vertex as usize][height_axis];
        let foot = below.map_or(least, |[foot, _]| height(self, foot));
        if foot >= height(self, a) {
            return;
        }
        let [c, d] = below.unwrap_or_else(|| {
            [a, b].map(|top| {
                let mut position = self.vertices[top as usize];
                position[height_axis] = least;
                self.vertices.push(position);
                (self.vertices.len() - 1) as u32
            })
        });
        // The corners of a top are counterclockwise, so the wall is seen from outside in this order.
        self.quad([b, a, c, d]);
    }

    fn add_surface(&mut self) {
        let [columns, rows] = self.raster.size;
        let mut centres = vec![None; columns * rows];
        self.vertices.reserve(columns * rows);
        self.triangles.reserve(2 * columns * rows);
        for (at, centre) in centres.iter_mut().enumerate() {
            let (column, row) = (at % columns, at / columns);
            let place = [column, row].map(|c| c as f64 + 0.5);
            *centre = self.height(at).map(|height| self.vertex(place, height));
        }
        for row in 1..rows {
            for column in 1..columns {
                let at = |west: usize, north: usize| centres[(row - north) * columns + column - west];
                let [nw, sw, se, ne] = [at(1, 1), at(1, 0), at(0, 0), at(0, 1)];
                for corners in [[nw, sw, se], [nw, se, ne]] {
                    if let [Some(a), Some(b), Some(c)] = corners {
                        self.triangles.push([a, b, c]);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use adumbra::grid::vec3::{cross, dot};

    use super::*;

    const NAN: f64 = f64::NAN;
    const CORNER: [f64; 2] = [100.0, 50.0];
    const CELL: f64 = 2.0;

    fn raster(heights: &[f64], columns: usize, surface: HeightSurface) -> Heights<'_> {
        let size = [columns, heights.len() / columns];
        Heights { heights, size, cell: CELL, corner: CORNER, surface }
    }

    /// A triangle's corners, and its normal with the length of its area.
    struct Triangle([[f64; 3]; 3], [f64; 3]);

    fn triangles(scene: &Scene) -> impl Iterator<Item = Triangle> {
        let mesh = &scene.meshes[0];
        mesh.triangles.iter().map(|corners| {
            let [a, b, c] = corners.map(|v| scene.instances[0].to_world(mesh.positions[v as usize]));
            let [u, v] = [b, c].map(|p| [0, 1, 2].map(|i| p[i] - a[i]));
            Triangle([a, b, c], cross(u, v).map(|c| 0.5 * c))
        })
    }

    /// A cell without data, neighbours of three heights, and steps that go down to every side.
    const STEPS: [f64; 12] = [1.0, 4.0, 8.0, 4.0, 4.0, 8.0, NAN, 1.0, 1.0, 1.0, 4.0, 5.0];

    #[test]
    fn blocks_have_level_tops_and_outward_walls() {
        for up in [UpAxis::Y, UpAxis::Z] {
            let scene = from_heights("raster", &raster(&STEPS, 4, HeightSurface::Blocks), up).unwrap();
            let bounds = scene.bounds();
            let north = if up == UpAxis::Y { CORNER[1] } else { -CORNER[1] };
            assert_eq!((bounds.min, bounds.max), ([100.0, 1.0, north], [108.0, 8.0, north + 6.0]), "{up:?}");
            let (mut tops, mut walls, mut volume) = (0.0, 0.0, 0.0);
            for Triangle([a, ..], normal) in triangles(&scene) {
                if normal[1] == 0.0 {
                    walls += dot(normal, normal).sqrt();
                } else {
                    assert!(normal[0] == 0.0 && normal[1] > 0.0 && normal[2] == 0.0, "{normal:?}");
                    tops += normal[1];
                }
                // About a point of the floor at the lowest height, to which the floor adds nothing.
                let place = [a[0] - 101.0, a[1] - 1.0, a[2] - north];
                volume += dot(place, normal) / 3.0;
            }
            let heights = STEPS.map(|height| if height.is_nan() { 1.0 } else { height });
            assert_eq!(tops, 11.0 * CELL * CELL, "{up:?}");
            let expected: f64 = heights.iter().map(|height| (height - 1.0) * CELL * CELL).sum();
            assert!((volume - expected).abs() < 1e-9, "{up:?}: {volume}, not {expected}");
            let at = |column: usize, row: usize| {
                if (1..=4).contains(&column) && (1..=3).contains(&row) {
                    heights[(row - 1) * 4 + column - 1]
                } else {
                    1.0
                }
            };
            let steps: f64 = (0..=4)
                .flat_map(|column| (0..=3).map(move |row| (column, row)))
                .map(|(column, row)| {
                    let own = at(column, row);
                    (own - at(column + 1, row)).abs() + (own - at(column, row + 1)).abs()
                })
                .sum();
            assert_eq!(walls, steps * CELL, "{up:?}");
        }
    }

    #[test]
    fn rows_go_south_and_columns_east() {
        let heights = [1.0, 1.0, 1.0, 1.0, 1.0, 9.0];
        for (up, north) in [(UpAxis::Y, CORNER[1]), (UpAxis::Z, -CORNER[1])] {
            let scene = from_heights("raster", &raster(&heights, 3, HeightSurface::Blocks), up).unwrap();
            let corners = triangles(&scene).flat_map(|Triangle(corners, _)| corners);
            let mut high: Vec<_> = corners.filter(|p| p[1] == 9.0).map(|p| [p[0], p[2] - north]).collect();
            high.sort_by(|a, b| a.partial_cmp(b).expect("finite"));
            high.dedup();
            assert_eq!(high, [[104.0, 2.0], [104.0, 4.0], [106.0, 2.0], [106.0, 4.0]], "{up:?}");
        }
    }

    #[test]
    fn surface_passes_through_the_centres() {
        let heights = [0.0, 1.0, 2.0, 0.0, 1.0, 2.0, 0.0, 1.0, NAN];
        for (up, north) in [(UpAxis::Y, CORNER[1]), (UpAxis::Z, -CORNER[1])] {
            let scene = from_heights("raster", &raster(&heights, 3, HeightSurface::Centres), up).unwrap();
            let bounds = scene.bounds();
            assert_eq!((bounds.min, bounds.max), ([101.0, 0.0, north + 1.0], [105.0, 2.0, north + 5.0]));
            assert_eq!(scene.instanced_triangles(), 8 - 1 - 1);
            for Triangle(corners, normal) in triangles(&scene) {
                assert!(normal[1] > 0.0, "{up:?}: {normal:?}");
                // It rises by 1 per cell to the east.
                assert!(corners.iter().all(|p| (p[0] - 101.0) / CELL == p[1]), "{up:?}: {corners:?}");
            }
        }
    }

    #[test]
    fn faulty_rasters_are_errors() {
        let heights = [1.0; 6];
        let good = raster(&heights, 3, HeightSurface::Blocks);
        let text = |raster| from_heights("dsm", &raster, UpAxis::Z).unwrap_err().to_string();
        assert!(text(Heights { size: [4, 2], ..good }).contains("6 heights for 4 columns and 2 rows"));
        for cell in [0.0, -1.0, NAN, f64::INFINITY] {
            assert!(text(Heights { cell, ..good }).contains("give a length above 0"), "{cell}");
        }
        assert!(text(Heights { corner: [0.0, NAN], ..good }).contains("corner at [0.0, NaN]"));
        let infinite = [1.0, 1.0, 1.0, 1.0, 1.0, f64::INFINITY];
        assert!(text(raster(&infinite, 3, HeightSurface::Blocks)).contains("row 1, column 2"));
        assert!(text(raster(&[NAN; 4], 2, HeightSurface::Blocks)).contains("no cell with data"));
        assert!(text(raster(&heights, 6, HeightSurface::Centres)).contains("6 columns and 1 rows, too few"));
    }
}
