//! Faults of the header and the sections of graph files.

use super::{Bytes, LEAF_MASKS, NODES, TOP};
use crate::broken::Broken;

/// Two files of a kind that are being broken.
pub(super) struct Files {
    /// The magic as the messages show it.
    pub(super) magic: &'static str,
    /// The first version that is not read, as the messages show it.
    pub(super) later: &'static str,
    /// A small file whose bytes are all known.
    pub(super) small: Bytes,
    /// A file with more than 32 bytes in its second section, and a third section that is not empty.
    pub(super) full: Bytes,
}

impl Files {
    /// Returns the files with one fault each.
    pub(super) fn broken(&self) -> Vec<Broken> {
        let Self { magic, later, small, full } = self;
        let (s, f) = (|| small.clone(), || full.clone());
        let damaged = |at: usize| f().put(at, &[full.0[at] ^ 0x5A]).0;
        let nan = f64::NAN;
        let roots = (1_u32 << (32 - small.word(36))).to_le_bytes().repeat(3);
        let mut all = Vec::new();
        let mut add = |name, error, names, bytes| all.push(Broken { name, error, fault: None, names, bytes });

        add("empty", "Truncated", "header", Vec::new());
        add("magic", "Magic", magic, s().put(0, b"GIF89a\0\0").0);
        add("copied_as_text", "Magic", magic, s().put(7, b"\r").0);
        add("future_version", "FutureVersion", later, s().put_word(8, small.word(8) + 1).sealed());
        add("version_0", "HeaderField", "version", s().put_word(8, 0).sealed());
        add("header_length", "HeaderField", "header_bytes", s().put_word(12, 256).sealed());
        add("cut_in_header", "Truncated", "header", s().cut(200).0);
        add("cut_in_half", "Truncated", "nodes", f().cut(full.section(NODES) + 20).0);
        add("cut_last_byte", "Truncated", "leaf_masks", f().cut(full.0.len() - 1).0);
        add("goes_on", "TrailingBytes", "end", [s().0, vec![0]].concat());
        add("header_damaged", "HeaderChecksum", "header", s().put_word(20, 16).0);
        add("top_damaged", "SectionChecksum", "top", damaged(full.section(TOP)));
        add("nodes_damaged", "SectionChecksum", "nodes", damaged(full.section(NODES) + 9));
        add("leaf_masks_damaged", "SectionChecksum", "leaf_masks", damaged(full.section(LEAF_MASKS)));
        add("padding", "Padding", "between", s().put(small.section(NODES) - 1, &[1]).0);
        add("unknown_flag", "HeaderField", "flags", s().put_word(16, 1 << 6).sealed());
        add("resolution_0", "HeaderField", "resolution", s().put_word(20, 0).sealed());
        add("size_0", "HeaderField", "size", s().put_word(28, 0).sealed());
        add("root_level_2", "HeaderField", "root_level", s().put_word(36, 2).sealed());
        add("root_level_21", "HeaderField", "root_level", s().put_word(36, 21).sealed());
        add("top_dims", "HeaderField", "top_dims", s().put_word(40, 2).sealed());
        add("layout_unknown", "HeaderField", "layout", s().put_word(52, 7).sealed());
        add("reserved_tail", "HeaderField", "reserved", s().put_word(376, 1).sealed());
        add("voxel_size_0", "HeaderField", "voxel_size", s().put_f64(56, 0.0).sealed());
        add("voxel_size_infinite", "HeaderField", "voxel_size", s().put_f64(56, f64::INFINITY).sealed());
        add("sun_not_unit", "HeaderField", "sun", s().put_f64(72, 1.001).sealed());
        add("sun_below", "HeaderField", "sun", s().put_f64(72, -1.0).sealed());
        add("corner_nan", "HeaderField", "corner", s().put_f64(88, nan).sealed());
        add("frame_unknown", "HeaderField", "frame", s().put_word(356, 2).sealed());
        add("yaw_of_light", "HeaderField", "yaw", s().put_f64(360, 0.5).sealed());
        add("yaw_nan", "HeaderField", "yaw", s().put_word(356, 1).put_f64(360, nan).sealed());
        add("yaw_of_other_axes", "HeaderField", "axes", s().put_word(356, 1).put_f64(360, 0.5).sealed());
        add("axes_skew", "HeaderField", "axes", s().put_f64(120, 1e-6).sealed());
        add("axes_left_handed", "HeaderField", "axes", s().put_f64(112, -1.0).sealed());
        add("thickness_negative", "HeaderField", "thickness", s().put_f64(184, -0.1).sealed());
        add("bias_infinite", "HeaderField", "bias", s().put_f64(200, f64::NEG_INFINITY).sealed());
        add("bounds_without_flag", "HeaderField", "bounds", s().put_f64(216, 1.0).sealed());
        add("bounds_inverted", "HeaderField", "bounds", s().put_word(16, 0x13).put_f64(216, 1.0).sealed());
        add("section_in_header", "SectionBounds", "offset", s().put_word(280, 0).sealed());
        add("section_overlap", "SectionBounds", "offset", s().put_word(304, 384).sealed());
        add("section_far_away", "SectionBounds", "offset", s().put_word(332, 0x7FFF_FFFF).sealed());
        add("top_length", "SectionBounds", "length", s().put_word(288, small.word(288) + 4).sealed());
        add("nodes_length_odd", "SectionBounds", "length", s().put_word(312, 7).sealed());
        add("leaf_masks_length_huge", "SectionBounds", "length", s().put_word(340, 0x1000_0000).sealed());
        add("leaf_masks_length_past_end", "Truncated", "leaf_masks", s().put_word(336, 0x4000_0000).sealed());
        add("top_huge", "SectionBounds", "top", s().put(24, &[255; 12]).put(40, &roots).sealed());
        all
    }
}
