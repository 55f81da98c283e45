use super::*;
use crate::file::fields::is_path;
use crate::grid::{Frame, LightGrid, Sun};
use crate::query::Filter;
use crate::stream::BytesSource;

fn steps() -> Vec<SunStep> {
    let step = |minute: u32| {
        let sun = f64::from(minute).to_radians();
        SunStep { seconds: 60.0 * f64::from(minute), towards_sun: [sun.cos(), sun.sin(), 0.0] }
    };
    (0..=40).map(|m| step(4 * m)).collect()
}

fn written(steps: Vec<SunStep>, keys: &[(f64, Vec<u8>)]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    SunPath::write(&mut bytes, steps, keys, 3600, Some([48.0, -11.5]))?;
    Ok(bytes)
}

/// Shadow files of different lengths.
fn files() -> Vec<(f64, Vec<u8>)> {
    let named = [(300.0, "slopes"), (2400.0, "levels_coded"), (4800.0, "sphere")];
    named.map(|(seconds, name)| (seconds, vector(name))).to_vec()
}

fn vector(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../test_vectors/valid");
    std::fs::read(folder.join(format!("{name}_depths.adumbra"))).unwrap()
}

fn open(bytes: Vec<u8>) -> Result<SunPath> {
    SunPath::open(Arc::new(BytesSource(bytes)), "day")
}

#[test]
fn paths_round_trip() {
    let bytes = written(steps(), &files()).unwrap();
    let path = open(bytes.clone()).unwrap();
    assert_eq!(path.steps(), steps());
    assert_eq!((path.utc_offset_seconds(), path.place_degrees()), (3600, Some([48.0, -11.5])));
    assert_eq!((path.file_bytes(), path.key_seconds()), (bytes.len() as u64, vec![300.0, 2400.0, 4800.0]));
    for (index, (_, file)) in files().iter().enumerate() {
        let source = path.key_source(index);
        assert_eq!(&source.read(0..1 << 20).unwrap(), file);
        assert_eq!(source.read(3..9).unwrap(), &file[3..9]);
        assert_eq!(path.front.keys[index].offset % 8, 0);
        let file = ShadowFile::from_bytes(file).unwrap();
        assert_eq!(path.front.keys[index].words, file.gpu().words().count());
        assert!(path.key(index).unwrap() == file);
    }
    assert!(is_path(&bytes) && !is_path(b"ADUMBRA\n"));
}

#[test]
fn sun_between_steps_is_on_arc_and_never_below_horizon() {
    let path = open(written(steps(), &files()).unwrap()).unwrap();
    for degrees in [0.5, 1.0, 45.25, 159.0, 160.0] {
        let [x, y, z] = path.sun_at(60.0 * degrees).unwrap();
        let expected = degrees.to_radians();
        assert!((x - expected.cos()).abs() < 1e-12 && (y - expected.sin()).abs() < 1e-12 && z == 0.0);
    }
    assert_eq!(path.sun_at(0.0), None, "on the horizon");
    assert_eq!((path.sun_at(-1.0), path.sun_at(9601.0)), (None, None), "beside the path");
    let mut sets = steps();
    sets.iter_mut().skip(20).for_each(|step| step.towards_sun[1] *= -1.0);
    let path = open(written(sets, &files()).unwrap()).unwrap();
    assert!(path.sun_at(4000.0).is_some() && path.sun_at(6000.0).is_none());
    assert_eq!(path.keys_at(6000.0), None);
}

#[test]
fn higher_key_comes_first_unless_other_is_much_nearer() {
    // The sun rises from key to key.
    let path = open(written(steps(), &files()).unwrap()).unwrap();
    for (seconds, keys) in [
        (100.0, [0, 0]),
        (300.0, [0, 0]),
        (700.0, [0, 1]),
        (720.0, [0, 1]),
        (721.0, [1, 0]),
        (2300.0, [1, 0]),
        (2400.0, [1, 1]),
        (2500.0, [1, 2]),
        (4700.0, [2, 1]),
        (9000.0, [2, 2]),
    ] {
        assert_eq!(path.keys_at(seconds), Some(keys), "{seconds}");
    }
    // The last key may be at the last step.
    let path = open(written(steps()[..=20].to_vec(), &files()).unwrap()).unwrap();
    assert_eq!([3600.0, 4800.0].map(|seconds| path.keys_at(seconds)), [Some([2, 1]), Some([2, 2])]);
}

#[test]
fn rejects_invalid_paths_with_reason() {
    let unordered = [(5.0, vector("slopes")), (4.0, vector("slopes"))];
    let long = vec![SunStep { seconds: 0.0, towards_sun: [0.0, 2.0, 0.0] }];
    for (steps, keys, what) in [
        (steps(), &unordered[..], "keys"),
        (long, &files()[..], "unit vector"),
        (steps(), &[(0.0, vec![0; 10])], "not a shadow file"),
    ] {
        let error = written(steps, keys).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
    let bytes = written(steps(), &files()).unwrap();
    let damaged = |at: usize| {
        let mut bytes = bytes.clone();
        bytes[at] ^= 1;
        open(bytes).unwrap_err().to_string()
    };
    for (at, what) in
        [(0, "ADUMDAY"), (9, "version"), (40, "the header is damaged"), (200, "tables of the path")]
    {
        let error = damaged(at);
        assert!(error.contains(what) && error.contains("day"), "{error}");
    }
    for length in [0, 100, 500] {
        let error = open(bytes[..length].to_vec()).unwrap_err().to_string();
        assert!(error.contains("cut off"), "{length}: {error}");
    }
    let mut path = open(bytes.clone()).unwrap();
    for change in [|key: &mut KeyPlace| key.bytes = 10, |key: &mut KeyPlace| key.offset += 8] {
        let mut front = path.front.clone();
        change(&mut front.keys[0]);
        let error = open(front.encode()).unwrap_err().to_string();
        assert!(error.contains("a file at byte"), "{error}");
    }
    path.front.keys[1].words += 1;
    let error = path.key(1).unwrap_err().to_string();
    assert!(error.contains("words of a key"), "{error}");
    let mut in_key = bytes.clone();
    in_key[path.front.keys[1].offset as usize + 100] ^= 1;
    let error = open(in_key).unwrap().key(1).unwrap_err().to_string();
    assert!(error.contains("day"), "{error}");
    let error = ShadowFile::from_bytes(&written(steps(), &files()).unwrap()).unwrap_err().to_string();
    assert!(error.contains("this is a sun path"), "{error}");
}

#[test]
fn rejects_suns_too_far_from_the_files_own() {
    let sun = Sun::from_direction([0.0, 1.0, 0.0]).unwrap();
    let grid = LightGrid::new(sun, Frame::Oblique { yaw_radians: 0.0 }, 1.0, [0.0; 3], [16; 3]);
    let slope = |towards| crate::query::MarchSlope::new(&grid, towards);
    assert!(slope([0.6, 0.8, 0.0]).is_some());
    assert_eq!(slope([0.6, 0.8, 0.0]).unwrap().v_fixed, [49152, 0]);
    assert_eq!(slope([0.999_999_9, 1e-4, 0.0]), None, "10,000 texels per voxel");
    assert_eq!(slope([0.6, -0.8, 0.0]), None, "below the horizon");
}

/// Both keys are the same file, so they have the same taps lit.
#[test]
fn quick_look_ups_march_where_not_all_taps_agree() {
    let file = ShadowFile::from_bytes(&vector("sphere")).unwrap();
    let full = PathSampler::new([&file, &file], file.sun().towards(), Filter::Box5).unwrap();
    let (quick, taps) = (full.clone().quick(), file.sampler(Filter::Box5));
    let [nx, ny, nz] = file.grid.size;
    let mut partly = 0;
    for [i, j] in (0..ny).flat_map(|j| (0..nx).map(move |i| [i, j])) {
        for k in (0..nz).step_by(8) {
            let p = file.grid.to_world([i, j, k].map(|c| f64::from(c) + 0.5));
            let lit = taps.visibility(p, None);
            let expected = if lit == 0.0 || lit == 1.0 { lit } else { full.look_up(p, None) };
            assert_eq!(quick.look_up(p, None), expected, "{p:?}");
            partly += u32::from(expected > 0.0 && expected < 1.0);
        }
    }
    assert!(partly > 100, "{partly}");
}
