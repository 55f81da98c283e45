//! The data that a shader gets from a file: its words, the parameter block and the texture with both.

use adumbra::gpu::{Bindings, HEADER_WORDS, LookUp, Penumbra, TEXTURE_MAGIC, TEXTURE_VERSION, TexelFormat};
use adumbra::grid::Placement;
use adumbra::layout::depths::TreeBuilder;
use adumbra::query::MAX_FIXED_SIDE;
use adumbra::stream::{Resident, StreamOptions};
use adumbra::{Bias, Error, Filter, RangeField, ShadowFile};
use adumbra_testing::{overhead_grid, settings_for, vectors};

const ANCHOR: [f64; 3] = [-12.5, 3.25, 40.125];

fn file(name: &str) -> ShadowFile {
    ShadowFile::read(vectors(&format!("valid/{name}_depths.adumbra"))).expect("a valid file")
}

fn words_in(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks().0.iter().map(|&word| u32::from_le_bytes(word)).collect()
}

/// Returns words as `f32`.
fn floats<const N: usize>(words: &[u32]) -> [f32; N] {
    std::array::from_fn(|i| f32::from_bits(words[i]))
}

fn refused<T>(result: adumbra::Result<T>) -> RangeField {
    match result {
        Err(Error::Range(error)) => error.field,
        Err(error) => panic!("{error}"),
        Ok(_) => panic!("nothing is refused"),
    }
}

#[test]
fn words_are_blocks_then_code() {
    let file = file("many_pages");
    let (gpu, tree) = (file.gpu(), &file.tree);
    let expected = [tree.top().as_flattened(), tree.code()];
    assert!(expected.iter().all(|part| !part.is_empty()));
    assert_eq!(gpu.words().parts(), expected);
    assert_eq!(gpu.words().to_vec(), expected.concat());
    assert!(gpu.words().iter().eq(expected.concat()));
    assert_eq!(gpu.words().count(), expected.concat().len() as u64);
}

#[test]
fn parameters_are_at_documented_offsets() {
    for name in ["cliff", "upright_turned_low"] {
        let file = file(name);
        let (grid, tree) = (&file.grid, &file.tree);
        let look_up = LookUp { filter: Filter::Box9, ..LookUp::default() };
        let bytes = file.gpu().parameters(&look_up, ANCHOR).unwrap().to_bytes();
        assert_eq!(bytes.len(), 352);
        let words = words_in(&bytes);
        for a in 0..3 {
            assert_eq!(floats(&words[4 * a..]), grid.axes[a].map(|c| c as f32), "{name}");
            assert_eq!(floats(&words[12 + 4 * a..]), grid.edges[a].map(|c| c as f32), "{name}");
        }
        assert_eq!(floats(&words[56..]), grid.to_grid(ANCHOR).map(|c| c as f32), "{name}");
        assert_eq!(words[60..63], grid.size, "{name}");
        assert_eq!(floats(&words[63..]), [(1.0 / grid.voxel_size) as f32], "{name}");
        assert_eq!(words[68..72], [tree.top_dims()[0], tree.top_dims()[1], 1, tree.root_level()], "{name}");
        assert_eq!(floats(&words[72..]), [1.0, 0.5, 0.0, 1.0], "{name}: the file's own bias");
        assert_eq!(words[76..80], [0, 0, 0, 2 * tree.top().len() as u32], "{name}");
        assert_eq!(words[80..84], [9, 0, 0, 0], "{name}");
        let [[a, b], [c, d]] = grid.circle_across_light();
        assert_eq!(floats(&words[84..]), [a, b, c, d].map(|c| c as f32), "{name}");
    }
}

#[test]
fn default_look_up_takes_the_bias_of_the_file() {
    let mut file = file("sphere");
    let own = Bias { constant_texels: 2.5, slope_texels: 0.25, normal_offset_texels: 1.5 };
    file.settings.bias = own;
    let parameters = |look_up: LookUp| file.gpu().parameters(&look_up, ANCHOR).unwrap();
    let default = parameters(LookUp::default());
    assert_eq!((default.bias, default.filter_width), (own, Filter::default().width()));
    assert_eq!((default.sun_cone, default.max_radius_texels), (0.0, 0.0));
    let other = Bias { constant_texels: 4.0, ..own };
    assert_eq!(parameters(LookUp { bias: Some(other), ..LookUp::default() }).bias, other);
}

#[test]
fn penumbrae_replace_the_filter() {
    let file = file("upright");
    let penumbra = Penumbra { sun_degrees: 2.0, max_radius_texels: 20.5 };
    let look_up = LookUp { filter: Filter::Box17, penumbra: Some(penumbra), ..LookUp::default() };
    let found = file.gpu().parameters(&look_up, ANCHOR).unwrap();
    let cone = file.grid.cone_texels_per_voxel(2.0) as f32;
    assert_eq!((found.filter_width, found.sun_cone, found.max_radius_texels), (1, cone, 20.5));
    assert_eq!(floats(&words_in(&found.to_bytes())[81..]), [cone, 20.5]);
}

#[test]
fn look_up_out_of_range_is_refused() {
    let file = file("sphere");
    let with = |penumbra: Penumbra| LookUp { penumbra: Some(penumbra), ..LookUp::default() };
    let both_ways = |look_up: LookUp| {
        let field = refused(file.gpu().parameters(&look_up, ANCHOR));
        assert_eq!(refused(file.gpu().texture(&look_up, 4096)), field);
        field
    };
    for sun_degrees in [0.0, 0.009, 20.1, f64::NAN] {
        assert_eq!(both_ways(with(Penumbra { sun_degrees, ..Penumbra::default() })), RangeField::SunDegrees);
    }
    for max_radius_texels in [0.5, 64.5, f64::NAN] {
        let penumbra = Penumbra { max_radius_texels, ..Penumbra::default() };
        assert_eq!(both_ways(with(penumbra)), RangeField::PenumbraRadius);
    }
    let bias = Some(Bias { slope_texels: 17.0, ..Bias::default() });
    assert_eq!(both_ways(LookUp { bias, ..LookUp::default() }), RangeField::BiasTerm);

    let size = [8, 8, MAX_FIXED_SIDE + 1];
    let tree = TreeBuilder::new(size, Vec::new()).finish().unwrap();
    let grid = overhead_grid([0.0, 8.0, 0.0], size);
    let tall = ShadowFile::new(grid, settings_for(&grid), tree);
    assert_eq!(refused(tall.gpu().parameters(&LookUp::default(), ANCHOR)), RangeField::LongestSide);
}

#[test]
fn texture_holds_words_and_parameters() {
    for name in ["cliff", "slopes", "upright", "many_pages"] {
        let file = file(name);
        let gpu = file.gpu();
        let look_up = LookUp::default();
        let mut texture = gpu.texture(&look_up, 4096).unwrap();
        let anchor = texture.anchor_world();
        let parameters = gpu.parameters(&look_up, anchor.map(f64::from)).unwrap();
        assert_eq!(*texture.parameters(), parameters);

        let texels = words_in(texture.bytes());
        assert!(texture.width().is_power_of_two());
        assert_eq!(texels.len() as u32, texture.width() * texture.height());
        let (header, rest) = texels.split_at(HEADER_WORDS);
        let count = gpu.words().count();
        assert_eq!(header[..4], [TEXTURE_MAGIC, TEXTURE_VERSION, 2, count as u32]);
        assert_eq!(floats(&header[4..]), anchor);
        assert_eq!(floats(&header[8..]), file.sun().towards().map(|c| c as f32));
        assert_eq!(header[16..104], words_in(&parameters.to_bytes()));
        assert!([7..8, 11..16, 104..128].into_iter().all(|zeros| header[zeros].iter().all(|&w| w == 0)));
        let (words, padding) = rest.split_at(count as usize);
        assert_eq!(words, gpu.words().to_vec());
        assert!(padding.iter().all(|&word| word == 0));

        // Another look-up changes only the header.
        let before = texture.bytes().to_vec();
        assert_eq!(texture.header(), &before[..4 * HEADER_WORDS]);
        // Columns: a turn about y, twice as large, and a move.
        let columns =
            [[0.0, 0.0, -2.0, 0.0], [0.0, 2.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0], [9.0, 0.0, 1.0, 1.0]];
        let placement = Placement::from_matrix(columns).unwrap();
        for other in [
            LookUp { filter: Filter::Box17, ..look_up },
            LookUp { penumbra: Some(Penumbra::default()), ..look_up },
            LookUp { bias: Some(Bias { constant_texels: 2.0, ..Bias::default() }), placement, ..look_up },
        ] {
            texture.set_look_up(&other).unwrap();
            let fresh = gpu.texture(&other, 4096).unwrap();
            assert_eq!(texture.header(), gpu.texture_header(&other).unwrap());
            assert_eq!((texture.bytes(), texture.parameters()), (fresh.bytes(), fresh.parameters()));
            assert_eq!(texture.anchor_world(), fresh.anchor_world());
            assert_eq!(texture.bytes()[4 * HEADER_WORDS..], before[4 * HEADER_WORDS..]);
        }
        let unfit = Penumbra { sun_degrees: 0.0, ..Penumbra::default() };
        let header = texture.header().to_vec();
        let unfit = LookUp { penumbra: Some(unfit), ..look_up };
        assert_eq!(refused(texture.set_look_up(&unfit)), RangeField::SunDegrees);
        assert_eq!(texture.header(), header);
        assert_eq!(refused(gpu.texture(&look_up, 100)), RangeField::TextureWords);
    }
}

/// Returns the variables with bindings that a text declares, without their names and types.
fn declared(wgsl: &str) -> Vec<&str> {
    let lines = wgsl.lines().filter(|line| line.starts_with('@') && line.contains("binding"));
    lines.map(|line| line.split(" adumbra_").next().unwrap_or_default()).collect()
}

#[test]
fn wgsl_declares_its_bindings_where_asked() {
    let file = file("many_pages");
    let texture = file.gpu().texture(&LookUp::default(), 4096).unwrap();
    let stream = Resident::new(StreamOptions::default());
    let bindings = Bindings { group: 3, first: 7 };
    for text in [file.gpu().wgsl(bindings), stream.wgsl(bindings)] {
        let mut found = declared(&text);
        found.sort_unstable();
        let expected = ["@group(3) @binding(7) var<uniform>", "@group(3) @binding(8) var<storage, read>"];
        assert_eq!(found, expected);
    }
    for format in [TexelFormat::R32Uint, TexelFormat::Rgba8Unorm] {
        assert_eq!(declared(&texture.wgsl(format, bindings)), ["@group(3) @binding(7) var"]);
    }
}
