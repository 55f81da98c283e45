//! A triangle of a mesh, as stored in clusters.

/// One triangle.
#[derive(Clone, Copy)]
pub(crate) struct ClusterTriangle {
    /// Index into the mesh's triangles.
    pub(crate) triangle: u32,
    /// Whether its material casts. A triangle that does not cast still receives.
    pub(crate) casts: bool,
    /// Whether it bounds a solid.
    pub(crate) solid: bool,
    /// Whether its material has holes.
    pub(crate) masked: bool,
    /// Connected component of the mesh.
    pub(crate) component: u32,
}
