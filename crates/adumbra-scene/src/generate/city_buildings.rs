//! Buildings made of closed boxes: plain ones, towers with set-backs, offices with floor plates, slabs on a
//! podium.

use crate::generate::city_measures::PAVEMENT;
use crate::generate::shapes::MeshBuilder;
use crate::generate::{SINK, Stage};
use crate::random::Random;

const STOREY: f64 = 3.4;

/// A piece of ground in (x, z).
#[derive(Clone, Copy)]
pub(super) struct Lot {
    pub(super) min: [f64; 2],
    pub(super) max: [f64; 2],
}

impl Lot {
    fn inset(self, by: f64) -> Self {
        Self { min: self.min.map(|c| c + by), max: self.max.map(|c| c - by) }
    }

    fn size(self) -> [f64; 2] {
        [self.max[0] - self.min[0], self.max[1] - self.min[1]]
    }

    fn narrow(self) -> f64 {
        self.size()[0].min(self.size()[1])
    }

    /// A point given as fractions of the lot's size.
    fn at(self, u: f64, v: f64) -> [f64; 2] {
        [self.min[0] + u * self.size()[0], self.min[1] + v * self.size()[1]]
    }

    fn corners(self, low: f64, high: f64) -> [[f64; 3]; 2] {
        [[self.min[0], low, self.min[1]], [self.max[0], high, self.max[1]]]
    }
}

/// The materials of buildings.
pub(super) struct Palette {
    walls: Vec<u32>,
    glass: Vec<u32>,
    trim: u32,
    roof: u32,
    metal: u32,
    timber: u32,
}

impl Palette {
    pub(super) fn new(stage: &mut Stage) -> Self {
        let walls = [0xC9B28F, 0xB56B52, 0xD8CDB8, 0x9C8A7A, 0xBF8F6A, 0xA9B0B3, 0xE1D8C8, 0x8E5F50];
        let glass = [0x5F7C8C, 0x4C6677, 0x6F8F8E];
        Self {
            walls: walls.into_iter().map(|c| stage.material("wall", c)).collect(),
            glass: glass.into_iter().map(|c| stage.material("glass", c)).collect(),
            trim: stage.material("trim", 0xDDD6C6),
            roof: stage.material("roof housing", 0x9A9792),
            metal: stage.material("roof metal", 0xB4B8BA),
            timber: stage.material("tank", 0x8A6A4C),
        }
    }
}

/// Where buildings are placed, and what they are made of.
pub(super) struct Site<'a> {
    pub(super) builder: &'a mut MeshBuilder,
    pub(super) palette: &'a Palette,
    pub(super) random: &'a mut Random,
}

impl Site<'_> {
    /// Places a building on the lot; `downtown` is 1 in the middle of the city and 0 at its edge.
    pub(super) fn building(&mut self, lot: Lot, downtown: f64) {
        let Self { palette, random, .. } = self;
        let storeys = (random.range(3.0, 7.5) + downtown * downtown * random.range(2.0, 34.0)).floor();
        let slim = (lot.narrow() / 4.0).floor() * 4.0;
        let height = PAVEMENT + STOREY * storeys.min(slim * 2.0);
        let wall = random.pick(&palette.walls);
        let base = PAVEMENT - SINK;
        match random.below(4) {
            _ if storeys >= 11.0 && random.chance(0.6) => self.set_backs(lot, [base, height], wall),
            0 if storeys >= 6.0 => self.plates(lot, [base, height]),
            1 if storeys >= 7.0 => self.podium(lot, [base, height], wall),
            _ => self.plain(lot, [base, height], wall, storeys),
        }
    }

    fn plain(&mut self, lot: Lot, [base, height]: [f64; 2], wall: u32, storeys: f64) {
        let trim = self.palette.trim;
        self.tier(lot, [base, height], wall);
        // A shop front with a string course above it.
        let shop = PAVEMENT + STOREY * 0.85;
        let glass = self.random.pick(&self.palette.glass);
        self.tier(lot.inset(-0.06), [base, shop], glass);
        self.tier(lot.inset(-0.25), [shop, shop + 0.35], trim);
        // Tall buildings get more string courses.
        let mut y = shop + 4.0 * STOREY;
        while storeys >= 9.0 && y < height - 2.0 * STOREY {
            self.tier(lot.inset(-0.18), [y, y + 0.4], trim);
            y += 4.0 * STOREY;
        }
        self.roof(lot, height, wall);
    }

    fn tier(&mut self, lot: Lot, [low, high]: [f64; 2], material: u32) {
        let [min, max] = lot.corners(low, high);
        self.builder.paint(material).cuboid(min, max);
    }

    /// Tiers that step back, each sunk slightly into the one below.
    fn set_backs(&mut self, lot: Lot, [base, height]: [f64; 2], wall: u32) {
        let trim = self.palette.trim;
        let (mut lot, mut low) = (lot, base);
        let tiers = 3 + self.random.below(2);
        for i in 0..tiers {
            let share = f64::from(i as u32 + 1) / tiers as f64;
            let high = base + (height - base) * (0.35 * share + 0.65 * share * (2.0 - share)).min(1.0);
            self.tier(lot, [low, high], wall);
            if i + 1 == tiers || lot.narrow() < 9.0 {
                self.roof(lot, high, trim);
                return;
            }
            self.cornice(lot, high, trim);
            low = high - SINK;
            lot = lot.inset(lot.narrow() * self.random.range(0.08, 0.16));
        }
    }

    /// A glass core with a plate at each floor.
    fn plates(&mut self, lot: Lot, [base, height]: [f64; 2]) {
        let trim = self.palette.trim;
        let every = if height > 45.0 { 3.0 } else { 2.0 };
        let glass = self.random.pick(&self.palette.glass);
        self.tier(lot.inset(0.4), [base, height], glass);
        let mut y = PAVEMENT + STOREY;
        while y < height - 1.0 {
            self.tier(lot, [y - 0.3, y + 0.3 * every], trim);
            y += STOREY * every;
        }
        self.roof(lot, height, trim);
    }

    /// A slab on a wider base.
    fn podium(&mut self, lot: Lot, [base, height]: [f64; 2], wall: u32) {
        let trim = self.palette.trim;
        let low = PAVEMENT + STOREY * (2.0 + self.random.below(2) as f64);
        let base_wall = self.random.pick(&self.palette.walls);
        self.tier(lot, [base, low], base_wall);
        self.cornice(lot, low, trim);
        let mut slab = lot.inset(1.2);
        let a = self.random.below(2);
        let spare = slab.size()[a] * self.random.range(0.25, 0.45);
        if self.random.chance(0.5) {
            slab.min[a] += spare;
        } else {
            slab.max[a] -= spare;
        }
        self.tier(slab, [low - SINK, height], wall);
        self.roof(slab, height, trim);
    }

    /// A parapet that overhangs the wall slightly.
    fn cornice(&mut self, lot: Lot, y: f64, material: u32) {
        let [min, max] = lot.inset(-0.12).corners(y - 0.35, y + 0.7);
        self.builder.paint(material).ring(min, max, 0.4);
    }

    /// A parapet, and on larger roofs a stair housing and a water tank or machinery.
    fn roof(&mut self, lot: Lot, y: f64, parapet: u32) {
        self.cornice(lot, y, parapet);
        if lot.narrow() < 7.0 {
            return;
        }
        let Self { builder: b, palette, random } = self;
        let low = y - SINK;
        let [x, z] = lot.at(random.range(0.25, 0.4), random.range(0.3, 0.7));
        b.paint(palette.roof).block([x, low, z], [2.6, 2.7, 3.6]);
        let [x, z] = lot.at(0.74, random.range(0.25, 0.75));
        if random.chance(0.35) {
            b.paint(palette.metal);
            for [u, v] in [[-0.8, -0.8], [0.8, -0.8], [-0.8, 0.8], [0.8, 0.8]] {
                b.block([x + u, low, z + v], [0.18, 1.9, 0.18]);
            }
            b.paint(palette.timber).frustum([x, z], [y + 1.8, y + 4.2], [1.4, 1.3], 12);
            b.paint(palette.metal).frustum([x, z], [y + 4.15, y + 5.0], [1.55, 0.0], 12);
        } else {
            b.paint(palette.metal).block([x, low, z], [1.6, 1.2, 1.3]);
            if random.chance(0.5) {
                b.block([x, low, z + 1.9], [1.3, 0.9, 1.3]);
            }
        }
    }
}
