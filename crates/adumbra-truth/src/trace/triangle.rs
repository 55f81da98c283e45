//! Watertight ray-triangle test in `f64`. Source: Woop, Benthin, Wald, *Watertight Ray/Triangle
//! Intersection*, 2013.
//!
//! The ray is sheared onto its own z axis. A triangle is hit if its three edge functions about the origin do
//! not differ in sign. Rounding is monotone, so an edge function computed from rounded products has the sign
//! of the exact one or is zero. The two triangles that share an edge compute it from the same two vertices,
//! so no ray slips between them.
//!
//! Differences from the paper: it uses `f32`, this uses `f64`. If an edge function is zero, the paper
//! recomputes it in `f64`; here its sign is taken from the exact rounding errors of the two products (Dekker
//! 1971).

/// A triangle hit, before its material is considered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TriangleHit {
    /// Distance along the ray, in lengths of its direction.
    pub(super) t: f64,
    /// Barycentric weights of the three vertices; they sum to one.
    pub(super) barycentric: [f64; 3],
    /// True if the ray hits the counter-clockwise side.
    pub(super) front: bool,
}

/// A ray prepared for tests against many triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedRay {
    origin: [f64; 3],
    axes: [usize; 3],
    shear: [f64; 3],
    t_min: f64,
    t_max: f64,
}

impl ShearedRay {
    /// Prepares the ray; `direction` must be finite and not zero.
    pub(super) fn new(origin: [f64; 3], direction: [f64; 3], t_min: f64, t_max: f64) -> Self {
        let a = direction.map(f64::abs);
        let z = if a[0] > a[1] && a[0] > a[2] { 0 } else { 1 + usize::from(a[2] > a[1]) };
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if direction[z] < 0.0 {
            // Preserves the winding.
            std::mem::swap(&mut x, &mut y);
        }
        let shear = [direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]];
        Self { origin, axes: [x, y, z], shear, t_min, t_max }
    }

    /// Limits the ray to hits up to `t`.
    pub(super) fn shorten(&mut self, t: f64) {
        self.t_max = t;
    }

    /// Intersects the triangle `v` from either side, including its edges and corners and the ends of the
    /// range. A triangle that is exactly edge-on is not hit, but the adjacent ones are.
    pub(super) fn intersect(&self, v: &[[f32; 3]; 3]) -> Option<TriangleHit> {
        let [a, b, c] = [self.relative(v[0]), self.relative(v[1]), self.relative(v[2])];
        let mut e = [c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]];
        if e[0] == 0.0 || e[1] == 0.0 || e[2] == 0.0 {
            e = [
                difference_of_products(c[0], b[1], c[1], b[0]),
                difference_of_products(a[0], c[1], a[1], c[0]),
                difference_of_products(b[0], a[1], b[1], a[0]),
            ];
        }
        if (e[0] < 0.0 || e[1] < 0.0 || e[2] < 0.0) && (e[0] > 0.0 || e[1] > 0.0 || e[2] > 0.0) {
            return None;
        }
        let det = e[0] + e[1] + e[2];
        if det == 0.0 {
            return None;
        }
        let barycentric = e.map(|x| x / det);
        let t = (barycentric[0] * a[2] + barycentric[1] * b[2] + barycentric[2] * c[2]) * self.shear[2];
        // Written so that NaN is a miss.
        (t >= self.t_min && t <= self.t_max).then_some(TriangleHit { t, barycentric, front: det > 0.0 })
    }

    /// A vertex relative to the origin, with the axes permuted and x and y sheared; z is not yet scaled.
    fn relative(self, v: [f32; 3]) -> [f64; 3] {
        let [x, y, z] = self.axes.map(|axis| f64::from(v[axis]) - self.origin[axis]);
        [x - self.shear[0] * z, y - self.shear[1] * z, z]
    }
}

/// Returns `a·b - c·d`. If the rounded products are equal, it returns the difference of their rounding
/// errors, so that the sign is exact (barring underflow).
fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let (ab, cd) = (a * b, c * d);
    if ab == cd { product_error(a, b, ab) - product_error(c, d, cd) } else { ab - cd }
}

/// The exact `a·b - ab`, where `ab` is the rounded product (Dekker's TwoProduct with Veltkamp's splitting).
fn product_error(a: f64, b: f64, ab: f64) -> f64 {
    let ((a_hi, a_lo), (b_hi, b_lo)) = (split(a), split(b));
    a_lo * b_lo - (((ab - a_hi * b_hi) - a_lo * b_hi) - a_hi * b_lo)
}

/// Splits `a` into a sum of two numbers of 26 bits each.
fn split(a: f64) -> (f64, f64) {
    let c = 134_217_729.0 * a;
    let hi = c - (c - a);
    (hi, a - hi)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    #[test]
    fn triangle_reports_t_weights_and_side() {
        let down = ShearedRay::new([0.25, 0.5, 3.0], [0.0, 0.0, -2.0], 0.0, f64::INFINITY);
        let hit = down.intersect(&TRIANGLE).unwrap();
        assert_eq!(hit, TriangleHit { t: 1.5, barycentric: [0.25, 0.25, 0.5], front: true });
        let up = ShearedRay::new([0.25, 0.5, -3.0], [0.0, 0.0, 1.0], 0.0, f64::INFINITY);
        assert!(!up.intersect(&TRIANGLE).unwrap().front);
        for axis in 0..3 {
            let turned = TRIANGLE.map(|p| [p[(3 - axis) % 3], p[(4 - axis) % 3], p[(5 - axis) % 3]]);
            let (mut o, mut d) = ([0.25; 3], [0.0; 3]);
            (o[(axis + 2) % 3], d[(axis + 2) % 3]) = (1.0, -1.0);
            assert!(ShearedRay::new(o, d, 0.0, 9.0).intersect(&turned).unwrap().front, "axis {axis}");
        }
    }

    #[test]
    fn triangle_includes_edges_corners_and_ends_of_the_range() {
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.5), (0.5, 0.0), (0.0, 0.5)] {
            let ray = |t_min, t_max| ShearedRay::new([x, y, 1.0], [0.0, 0.0, -1.0], t_min, t_max);
            assert!(ray(0.0, 9.0).intersect(&TRIANGLE).is_some(), "{x} {y}");
            assert!(ray(1.0, 1.0).intersect(&TRIANGLE).is_some(), "{x} {y}");
            assert!(ray(0.0, 0.999).intersect(&TRIANGLE).is_none());
            assert!(ray(1.001, 9.0).intersect(&TRIANGLE).is_none());
        }
        let beside = ShearedRay::new([0.5, 0.5 + 1e-15, 1.0], [0.0, 0.0, -1.0], 0.0, 9.0);
        assert!(beside.intersect(&TRIANGLE).is_none());
    }

    #[test]
    fn difference_of_products_has_the_exact_sign() {
        let a = 1.0 + f64::EPSILON;
        // (1 + e)² rounds to 1 + 2e; the exact difference is e².
        assert_eq!(difference_of_products(a, a, 1.0 + 2.0 * f64::EPSILON, 1.0), f64::EPSILON * f64::EPSILON);
        assert_eq!(difference_of_products(1.0 + 2.0 * f64::EPSILON, 1.0, a, a), -f64::EPSILON * f64::EPSILON);
        assert_eq!(difference_of_products(3.0, 5.0, 5.0, 3.0), 0.0);
    }
}
