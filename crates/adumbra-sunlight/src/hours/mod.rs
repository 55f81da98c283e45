//! The times at which points see the sun.
//!
//! The sun's path is taken as chords between its directions each 20 seconds, from which the true path departs
//! by 0.02", the sun's motion in 1.5 ms. A [`Fan`](adumbra_truth::trace::Fan) of rays finds when on these
//! chords it is hidden. Nothing is sampled, so no shadow or gap is missed, however soon it passes, except
//! through the holes of alpha masks, which are looked at each second.

mod spans;
mod trace;

pub use spans::Hours;
pub use trace::Suns;
