//! Points on the ground plan: the first surface below the sky, at the middle of each cell of a grid.

use adumbra::Bounds;
use adumbra_truth::trace::{Ray, Tracer};
use rayon::prelude::*;

use super::{Facing, Receiver, check_spacing};
use crate::error::{Error, Result};

/// A grid of square cells on the ground plan. Its lines are at multiples of the spacing, so the grids of two
/// designs for one site share cells. Row 0 is in the north, at the lowest z, and column 0 in the west, at the
/// lowest x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// x and z of the north-western corner, world units.
    pub corner_world: [f64; 2],
    /// Edge of a cell, world units.
    pub spacing_world: f64,
    /// Columns and rows.
    pub size: [u32; 2],
    /// Height from which the ground plan is seen, world units.
    pub top_world: f64,
}

/// The points of a grid. Cells with nothing below them have no point.
#[derive(Clone, Debug)]
pub struct GridPoints {
    /// The points, row by row.
    pub receivers: Vec<Receiver>,
    /// The cell of each point: its row times the columns, plus its column.
    pub cells: Vec<u32>,
}

impl Grid {
    /// Creates the grid that covers all of these boxes.
    ///
    /// # Errors
    /// Returns [`Error::Range`] if the spacing is not above 0, [`Error::TooManyPoints`] if it is too small,
    /// and [`Error::NoPoints`] if there is no box.
    pub fn over(bounds: &[Bounds], spacing_world: f64) -> Result<Self> {
        let fold = |pick: fn(&Bounds) -> f64, merge: fn(f64, f64) -> f64, start: f64| {
            bounds.iter().map(pick).fold(start, merge)
        };
        let [least, most] = [f64::INFINITY, f64::NEG_INFINITY];
        let low = [fold(|b| b.min[0], f64::min, least), fold(|b| b.min[2], f64::min, least)];
        let high = [fold(|b| b.max[0], f64::max, most), fold(|b| b.max[2], f64::max, most)];
        let top = fold(|b| b.max[1], f64::max, most);
        if !low.iter().chain(&high).chain([&top]).all(|c| c.is_finite()) {
            return Err(nothing());
        }
        let first = |a: usize| (low[a] / spacing_world).floor();
        let cells = |a: usize| ((high[a] / spacing_world).ceil() - first(a)).max(1.0);
        check_spacing(spacing_world, |_| cells(0) * cells(1))?;
        Ok(Self {
            corner_world: [0, 1].map(|a| first(a) * spacing_world),
            spacing_world,
            size: [0, 1].map(|a| cells(a) as u32),
            top_world: top + spacing_world,
        })
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Looks down at the middle of each cell, on the current rayon pool. Normals point up. Cost: one ray per
    /// cell.
    ///
    /// # Errors
    /// Returns [`Error::NoPoints`] if there is nothing below any cell.
    pub fn receivers(&self, tracer: &Tracer<'_>) -> Result<GridPoints> {
        let seen = (0..self.cells() as u32)
            .into_par_iter()
            .filter_map(|cell| Some((self.receiver(tracer, cell)?, cell)));
        let (receivers, cells): (Vec<_>, Vec<_>) = seen.unzip();
        if receivers.is_empty() { Err(nothing()) } else { Ok(GridPoints { receivers, cells }) }
    }

    fn receiver(&self, tracer: &Tracer<'_>, cell: u32) -> Option<Receiver> {
        let place = [cell % self.size[0], cell / self.size[0]];
        let [x, z] = [0, 1].map(|a| self.corner_world[a] + (f64::from(place[a]) + 0.5) * self.spacing_world);
        let origin = [x, self.top_world, z];
        let down = Ray { origin, direction: [0.0, -1.0, 0.0], t_min: 0.0, t_max: f64::INFINITY };
        let hit = tracer.nearest_surface(&down)?;
        let p_world = [x, self.top_world - hit.t, z];
        let normal = if hit.front { hit.normal } else { hit.normal.map(|c| -c) };
        Some(Receiver {
            p_world,
            facing: Facing::Front(normal),
            lift_world: tracer.lift_world(&hit, p_world),
        })
    }
}

fn nothing() -> Error {
    Error::NoPoints { place: "on the ground plan", advice: "check that the scene holds surfaces" }
}

#[cfg(test)]
mod tests {
    use adumbra_testing::{cuboid, scene_of};
    use adumbra_truth::trace::TraceOptions;

    use super::*;

    #[test]
    fn grid_points_are_on_the_topmost_surface() {
        let scene = scene_of(vec![
            cuboid([-2.0, -1.0, -3.0], [2.0, 0.0, 3.0]),
            cuboid([0.0, 0.0, -3.0], [1.0, 5.0, -2.0]),
        ]);
        let tracer = Tracer::build(&scene, TraceOptions::default());
        let grid = Grid::over(&[scene.bounds()], 1.0).unwrap();
        assert_eq!((grid.corner_world, grid.size), ([-2.0, -3.0], [4, 6]));
        let found = grid.receivers(&tracer).unwrap();
        assert_eq!(found.cells, (0..24).collect::<Vec<u32>>());
        for (receiver, cell) in found.receivers.iter().zip(&found.cells) {
            // The tower is in the northern row, in the third column.
            let height = if *cell == 2 { 5.0 } else { 0.0 };
            assert!((receiver.p_world[1] - height).abs() < 1e-9, "{cell}: {receiver:?}");
            assert_eq!(receiver.facing, Facing::Front([0.0, 1.0, 0.0]));
            assert!(receiver.lift_world > 0.0 && receiver.lift_world < 1e-3);
        }
        assert_eq!(found.receivers[2].p_world[0], 0.5);
        assert_eq!(found.receivers[2].p_world[2], -2.5);
    }

    #[test]
    fn grid_lines_are_at_multiples_and_empty_cells_are_skipped() {
        let scene = scene_of(vec![
            cuboid([0.3, 0.0, 0.3], [0.9, 1.0, 0.9]),
            cuboid([2.2, 0.0, 0.0], [2.8, 1.0, 1.0]),
        ]);
        let tracer = Tracer::build(&scene, TraceOptions::default());
        let grid = Grid::over(&[scene.bounds()], 1.0).unwrap();
        assert_eq!((grid.corner_world, grid.size), ([0.0, 0.0], [3, 1]));
        assert_eq!(grid.receivers(&tracer).unwrap().cells, [0, 2]);
        // A second design widens the grid, and the cells stay where they are.
        let wider = Bounds { min: [-1.5, 0.0, 0.2], max: [0.0, 9.0, 0.4] };
        let both = Grid::over(&[scene.bounds(), wider], 1.0).unwrap();
        assert_eq!((both.corner_world, both.size, both.top_world), ([-2.0, 0.0], [5, 1], 10.0));
    }

    #[test]
    fn rejects_grid_spacings_out_of_range() {
        let bounds = Bounds { min: [0.0; 3], max: [1000.0; 3] };
        for spacing in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(Grid::over(&[bounds], spacing), Err(Error::Range { .. })), "{spacing}");
        }
        assert!(matches!(Grid::over(&[bounds], 1e-3), Err(Error::TooManyPoints { .. })));
        assert!(matches!(Grid::over(&[], 1.0), Err(Error::NoPoints { .. })));
    }
}
