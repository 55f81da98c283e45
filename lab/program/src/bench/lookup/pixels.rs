//! The pixels whose look-ups are counted, in the groups that a GPU runs at once.

use adumbra::Sun;

use adumbra_compare::truth::Surfaces;

/// Pixels of a group along x and y.
const SIZE: [u32; 2] = [8, 4];

/// A surface point that faces the sun.
pub(super) struct Pixel {
    pub(super) p_world: [f64; 3],
    pub(super) normal: [f64; 3],
    pub(super) view_depth: f64,
}

/// The pixels of a group that face the sun.
pub(super) type Group = Vec<Pixel>;

/// Returns every n-th group of a view that has at least one pixel facing the sun.
pub(super) fn groups(surfaces: &Surfaces, sun: Sun, every: u32) -> Vec<Group> {
    let across = surfaces.width / SIZE[0];
    let all = across * (surfaces.height / SIZE[1]);
    (0..all)
        .step_by(every as usize)
        .map(|group| {
            let [left, top] = [group % across * SIZE[0], group / across * SIZE[1]];
            let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (left + x, top + y)));
            let pixels = pixels.map(|(x, y)| (y * surfaces.width + x) as usize);
            let faces = |i: &usize| surfaces.is_valid(*i) && surfaces.n_dot_l(*i, sun.towards()) > 0.0;
            let pixel = |i: usize| Pixel {
                p_world: surfaces.position[i],
                normal: surfaces.normal[i].map(f64::from),
                view_depth: surfaces.view_depth[i],
            };
            pixels.filter(faces).map(pixel).collect()
        })
        .filter(|group: &Group| !group.is_empty())
        .collect()
}
