//! The counts at the beginning of a Draco stream, read before anything is decoded.
//!
//! Source: the Draco bitstream specification 2.2 (Google, 2017), sections "Draco Decoder", "Metadata
//! Decoder", "Connectivity Decoder", "Sequential Connectivity Decoder" and "Edgebreaker Decoder". glTF allows
//! only this version of the format, and only triangle meshes.

/// How deep metadata may be nested.
const MAX_METADATA_DEPTH: u32 = 32;

/// The counts that a stream states.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    /// Number of triangles.
    pub(super) triangles: u64,
    /// Number of points; `None` if the connectivity decides it, which is then at most three per triangle.
    pub(super) points: Option<u64>,
    /// Number of attributes with separate connectivity.
    pub(super) seamed: u64,
}

impl Header {
    /// Reads the header of a stream. An error says what is wrong with the stream.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, String> {
        let cut = || "is cut off within its header".to_owned();
        let mut reader = Reader { bytes };
        if reader.take(5) != Some(b"DRACO") {
            return Err("does not begin with the letters DRACO".to_owned());
        }
        let fixed: [u8; 6] = reader.array().ok_or_else(cut)?;
        let [major, minor, geometry, method, flags_low, flags_high] = fixed;
        if (major, minor) != (2, 2) {
            return Err(format!("has version {major}.{minor} of the format; glTF uses 2.2"));
        }
        if geometry != 1 {
            return Err("is not a triangle mesh".to_owned());
        }
        if u16::from_le_bytes([flags_low, flags_high]) & 0x8000 != 0 {
            reader.skip_all_metadata().ok_or_else(|| "has broken metadata".to_owned())?;
        }
        let header = match method {
            0 => reader.sequential(),
            1 => reader.edgebreaker(),
            _ => return Err(format!("has the unknown encoding method {method}")),
        };
        header.ok_or_else(cut)
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
}

impl<'a> Reader<'a> {
    fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.bytes.split_at_checked(count)?;
        self.bytes = rest;
        Some(taken)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.take(N)?.try_into().ok()
    }

    /// A number in groups of seven bits, the lowest first.
    fn varint(&mut self) -> Option<u64> {
        let mut value = 0;
        for shift in (0..63).step_by(7) {
            let [byte] = self.array()?;
            value |= u64::from(byte & 0x7f) << shift;
            if byte & 0x80 == 0 {
                return Some(value);
            }
        }
        None
    }

    fn sequential(&mut self) -> Option<Header> {
        let (triangles, points) = (self.varint()?, self.varint()?);
        Some(Header { triangles, points: Some(points), seamed: 0 })
    }

    fn edgebreaker(&mut self) -> Option<Header> {
        let ([_traversal], _vertices, triangles) = (self.array()?, self.varint()?, self.varint()?);
        let [seamed] = self.array()?;
        Some(Header { triangles, points: None, seamed: u64::from(seamed) })
    }

    /// Skips the metadata of all attributes and of the mesh.
    fn skip_all_metadata(&mut self) -> Option<()> {
        for _ in 0..self.varint()? {
            self.varint()?;
            self.skip_metadata(0)?;
        }
        self.skip_metadata(0)
    }

    fn skip_metadata(&mut self, depth: u32) -> Option<()> {
        for _ in 0..self.varint()? {
            self.skip_name()?;
            let length = usize::try_from(self.varint()?).ok()?;
            self.take(length)?;
        }
        for _ in 0..self.varint()? {
            self.skip_name()?;
            self.skip_metadata((depth < MAX_METADATA_DEPTH).then_some(depth + 1)?)?;
        }
        Some(())
    }

    fn skip_name(&mut self) -> Option<()> {
        let [length] = self.array()?;
        self.take(length.into()).map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stream(method: u8, flags: u16, rest: &[u8]) -> Vec<u8> {
        let [low, high] = flags.to_le_bytes();
        [b"DRACO\x02\x02\x01".as_slice(), &[method, low, high], rest].concat()
    }

    #[test]
    fn reads_counts_of_both_connectivity_methods() {
        let read = |bytes: &[u8]| Header::read(bytes).expect("a header");
        let sequential = Header { triangles: 300, points: Some(5), seamed: 0 };
        assert_eq!(read(&stream(0, 0, &[0xac, 2, 5])), sequential);
        let edgebreaker = Header { triangles: 9, points: None, seamed: 3 };
        assert_eq!(read(&stream(1, 0, &[2, 7, 9, 3])), edgebreaker);
    }

    #[test]
    fn skips_metadata_before_the_counts() {
        // One attribute, number 4, with an entry a = [1, 2]; then the mesh, with no entries, but with a
        // sub-metadata b that has an entry c = [].
        let metadata = [1, 4, 1, 1, b'a', 2, 1, 2, 0, 0, 1, 1, b'b', 1, 1, b'c', 0, 0];
        let bytes = stream(0, 0x8000, &[&metadata[..], &[6, 5]].concat());
        assert_eq!(Header::read(&bytes), Ok(Header { triangles: 6, points: Some(5), seamed: 0 }));
        let deep = [&[0_u8, 0][..], &[1, 0, 0].repeat(1000)].concat();
        assert_eq!(Header::read(&stream(0, 0x8000, &deep)), Err("has broken metadata".to_owned()));
    }

    #[test]
    fn rejects_truncated_and_unsupported_headers() {
        let whole = stream(1, 0, &[2, 7, 9, 3]);
        for length in 0..whole.len() {
            assert!(Header::read(&whole[..length]).is_err(), "{length}");
        }
        let broken = |at: usize, value: u8| {
            let mut bytes = whole.clone();
            bytes[at] = value;
            Header::read(&bytes).expect_err("another kind")
        };
        assert!(broken(0, b'd').contains("letters DRACO"));
        assert!(broken(6, 3).contains("version 2.3"));
        assert!(broken(7, 0).contains("triangle mesh"));
        assert!(broken(8, 9).contains("method 9"));
        assert!(Header::read(&stream(0, 0, &[0xff; 20])).is_err(), "a number without end");
    }
}
