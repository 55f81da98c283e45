//! The motion of a sun, estimated from its past directions: along a great circle, at a speed.

use adumbra::grid::vec3::{cross, dot, normalize};

/// A larger step in one frame is a jump: the sun was set, so its future direction is unknown.
const JUMP_RADIANS: f64 = 0.05;
/// Time constant of the measured speed, in seconds of the caller's clock.
const MEMORY_SECONDS: f64 = 0.5;
/// Slower suns count as not moving. This is less than a hundredth of the sky's own rotation.
const LEAST_RADIANS_PER_SECOND: f64 = 7e-7;

/// The motion of a sun.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Motion {
    seen: Option<SunSample>,
    /// The rotation axis of the sun's motion. Its length is the speed in radians per second.
    turn: [f64; 3],
    /// The unit axis of the sun's last motion; zero if the sun has never moved.
    axis: [f64; 3],
}

#[derive(Clone, Copy, Debug)]
struct SunSample {
    seconds: f64,
    towards: [f64; 3],
}

impl Motion {
    /// Takes the sun's direction at a time. If the time is not after the last one, only the direction
    /// changes.
    pub(super) fn see(&mut self, seconds: f64, towards: [f64; 3]) {
        let last = self.seen.replace(SunSample { seconds, towards });
        let Some(last) = last else { return };
        let elapsed = seconds - last.seconds;
        let angle = angle(last.towards, towards);
        if angle > JUMP_RADIANS {
            self.turn = [0.0; 3];
        } else if elapsed > 0.0 {
            // The cross product is accurate for small angles, and the angle per frame is small.
            let now = cross(last.towards, towards).map(|c| c / elapsed);
            let share = if self.speed() == 0.0 { 1.0 } else { (elapsed / MEMORY_SECONDS).min(1.0) };
            self.turn = std::array::from_fn(|a| self.turn[a] + share * (now[a] - self.turn[a]));
            if self.speed() > 0.0 {
                self.axis = normalize(self.turn);
            }
        }
    }

    /// Returns the speed in radians per second; 0 if the sun does not move.
    pub(super) fn speed(&self) -> f64 {
        let speed = dot(self.turn, self.turn).sqrt();
        if speed < LEAST_RADIANS_PER_SECOND { 0.0 } else { speed }
    }

    /// Returns the direction at an angle beyond another direction, in radians.
    pub(super) fn after(&self, towards: [f64; 3], angle: f64) -> [f64; 3] {
        if self.speed() == 0.0 {
            return towards;
        }
        let axis = self.axis;
        let (sin, cos) = angle.sin_cos();
        let side = cross(axis, towards);
        let along = dot(axis, towards) * (1.0 - cos);
        normalize(std::array::from_fn(|a| cos * towards[a] + sin * side[a] + along * axis[a]))
    }

    /// Returns how far `b` is ahead of `a` along the sun's motion, in radians; negative if `b` is behind. It
    /// is 0 if the sun has not moved yet.
    pub(super) fn along(&self, a: [f64; 3], b: [f64; 3]) -> f64 {
        if self.axis == [0.0; 3] { 0.0 } else { dot(self.axis, cross(a, b)).atan2(dot(a, b)) }
    }
}

/// Returns the angle between two unit vectors, in radians.
pub(super) fn angle(a: [f64; 3], b: [f64; 3]) -> f64 {
    let across = cross(a, b);
    dot(across, across).sqrt().atan2(dot(a, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sun that turns about the world's z axis, from east to west.
    fn sun(degrees: f64) -> [f64; 3] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        [cos, sin, 0.0]
    }

    #[test]
    fn motion_predicts_a_steady_sun() {
        let mut motion = Motion::default();
        assert_eq!(motion.speed(), 0.0);
        for frame in 0..120 {
            let seconds = f64::from(frame) / 60.0;
            motion.see(seconds, sun(20.0 + 0.5 * seconds));
        }
        assert!((motion.speed().to_degrees() - 0.5).abs() < 1e-3, "{}", motion.speed().to_degrees());
        assert!(angle(motion.after(sun(21.0), 8f64.to_radians()), sun(29.0)) < 1e-6);
        assert!((motion.along(sun(21.0), sun(18.0)).to_degrees() + 3.0).abs() < 1e-6);
    }

    #[test]
    fn speed_is_zero_after_a_jump_and_after_a_stop() {
        let mut motion = Motion::default();
        motion.see(0.0, sun(20.0));
        motion.see(0.1, sun(20.5));
        assert!(motion.speed() > 0.0);
        motion.see(0.2, sun(70.0));
        assert_eq!(motion.speed(), 0.0);
        assert_eq!(motion.after(sun(70.0), 1.0), sun(70.0));
        motion.see(0.3, sun(70.5));
        motion.see(2.0, sun(70.5));
        assert_eq!(motion.speed(), 0.0);
        assert!(motion.along(sun(70.0), sun(80.0)) > 0.1, "the way it last went");
    }
}
