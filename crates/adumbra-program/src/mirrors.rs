//! Schemas of the reader's types that the programs print. The reader itself does not depend on `schemars`; a
//! field names the mirror of its type: `#[schemars(with = "mirrors::Bounds")]`.

use schemars::JsonSchema;

/// An axis-aligned box in world space.
#[derive(JsonSchema)]
pub struct Bounds {
    /// Corner with the smallest coordinates, world units.
    pub min: [f64; 3],
    /// Corner with the largest coordinates, world units.
    pub max: [f64; 3],
}

/// A square of the columns of a world that was cut into regions.
#[derive(JsonSchema)]
pub struct Region {
    /// Number along the grid's y.
    pub y: i32,
    /// Number along the grid's x.
    pub x: i32,
    /// Texels a side, at the finest level.
    pub texels: u32,
}

/// How a grid lies in the world. In either frame a sun ray is one column of voxels.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
pub enum Frame {
    /// Perpendicular to the light. Voxels are cubes, with z away from the sun and x horizontal.
    Light,
    /// Upright: a shear turns the light to the vertical. x and y are horizontal, and z is depth below the top
    /// of the grid.
    Oblique {
        /// Angle from the world's +X to the grid's x axis, in radians, positive towards +Z.
        yaw_radians: f64,
    },
}

/// The look-up bias, in texels of the light's plane.
#[derive(JsonSchema)]
pub struct Bias {
    /// Distance towards the sun, on every surface.
    pub constant_texels: f64,
    /// Distance towards the sun, multiplied by the slope: the tangent of the angle between normal and light.
    pub slope_texels: f64,
    /// Distance along the normal.
    pub normal_offset_texels: f64,
}

/// How the voxels of a file are stored.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
pub enum Encoding {
    /// As they are in memory.
    Raw,
    /// Coded, in about a third of the bytes.
    Coded,
}

/// The points at which a file must be correct.
#[derive(JsonSchema)]
#[schemars(rename_all = "lowercase")]
pub enum Receivers {
    /// All points in space.
    All,
    /// Only points on static surfaces, with a margin for filter and bias.
    Static,
}

/// The settings that determine what a file returns.
#[derive(JsonSchema)]
pub struct FileSettings {
    /// Number of texels on the longest side of the scene in the light's plane. If a voxel size was given, the
    /// smallest power of two that is at least that number.
    pub resolution: u32,
    /// How far below an open surface its shadow may begin, in world units; 0 = the bias at the surface's
    /// slope.
    pub thickness_world: f64,
    /// Whether the bake assumed that no static surface is behind the last one of a column.
    pub assume_ground: bool,
    /// Whether the insides of closed connected components are free, that is, may be lit or shadowed.
    pub closed_regions: bool,
    /// Whether alpha masks were ignored.
    pub ignore_alpha: bool,
    /// Whether Z points up in the scene's own file: its (x, y, z) is (x, z, −y) in the world, in which Y
    /// does.
    pub scene_is_z_up: bool,
    /// The points at which the file is correct.
    pub receivers: Receivers,
    /// How far behind its first surface a column may switch from lit to shadowed, in voxels. 0 = anywhere
    /// that no look-up from a surface reads.
    pub switch_within_voxels: u32,
    /// For marches to another sun: a ray that is hidden from both keys for so many voxels from its start on
    /// is taken to meet something. 0 = never.
    pub dark_after_voxels: u32,
    /// The box that fixed the extent of the grid, if one was given.
    pub bounds: Option<Bounds>,
    /// The region of a world that the file is of, if the world was cut into regions.
    pub region: Option<Region>,
    /// The look-up bias that the bake was made for.
    pub bias: Bias,
    /// Number of baked triangles, with those of every instance counted.
    pub triangles: u64,
    /// Number of baked instances.
    pub instances: u64,
}

#[cfg(test)]
mod tests {
    use adumbra_testing::assert_described;
    use serde_json::json;

    use super::*;

    #[test]
    fn mirror_schemas_match_the_readers_types() {
        let bounds = adumbra::Bounds { min: [0.0; 3], max: [1.0; 3] };
        let settings = adumbra::FileSettings {
            resolution: 64,
            thickness_world: 0.0,
            assume_ground: true,
            closed_regions: true,
            ignore_alpha: false,
            scene_is_z_up: true,
            receivers: adumbra::Receivers::All,
            switch_within_voxels: 0,
            dark_after_voxels: 0,
            bounds: Some(bounds),
            region: Some(adumbra::Region { x: -3, y: 2, texels: 4096 }),
            bias: adumbra::Bias::default(),
            triangles: 12,
            instances: 1,
        };
        let elsewhere = adumbra::FileSettings {
            receivers: adumbra::Receivers::Static,
            bounds: None,
            region: None,
            ..settings
        };
        let schema = schemars::schema_for!(FileSettings).to_value();
        assert_described(&schema, &json!(settings));
        assert_described(&schema, &json!(elsewhere));
        let encoding = schemars::schema_for!(Encoding).to_value();
        for way in [adumbra::Encoding::Raw, adumbra::Encoding::Coded] {
            assert_described(&encoding, &json!(way));
        }
        let frame = schemars::schema_for!(Frame).to_value();
        assert_described(&frame, &json!(adumbra::Frame::Light));
        assert_described(&frame, &json!(adumbra::Frame::Oblique { yaw_radians: 0.5 }));
    }
}
