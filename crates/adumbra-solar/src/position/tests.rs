//! Comparison of positions with published ones.

use super::*;

fn at(text: &str) -> f64 {
    text.parse::<Timestamp>().unwrap().as_second() as f64
}

fn sea(latitude: f64, longitude: f64) -> Location {
    Location::new(latitude, longitude, 0.0).unwrap()
}

/// The worked example of NREL/TP-560-34302, appendix A.5.
#[test]
fn position_matches_the_reports_worked_example() {
    let golden = Location::new(39.742_476, -105.178_6, 1830.14).unwrap();
    let air = Atmosphere { pressure_hpa: 820.0, temperature_celsius: 11.0 };
    let found = position(&golden, at("2003-10-17T12:30:30-07:00"), Some(&air)).unwrap();
    assert!((90.0 - found.elevation_degrees - 50.111_62).abs() < 1e-4, "{found:?}");
    assert!((found.azimuth_degrees - 194.340_24).abs() < 1e-4, "{found:?}");
}

/// The equation of time: the sun crosses Greenwich's meridian 16.4 minutes early on 3 November and 14.2
/// minutes late on 11 February.
#[test]
fn position_follows_the_equation_of_time() {
    for (noon, tolerance) in [("2024-11-03T11:43:34Z", 0.03), ("2024-02-11T12:14:13Z", 0.03)] {
        let found = position(&sea(51.4779, 0.0), at(noon), None).unwrap();
        assert!((found.azimuth_degrees - 180.0).abs() < tolerance, "{noon}: {found:?}");
    }
}

/// Declination at the solstices is 23.44° (USNO), so the height at noon is 90° less the distance of the
/// latitudes.
#[test]
fn elevation_at_solstice_noon_follows_declination() {
    for (noon, latitude, height) in [
        ("2024-06-20T12:02:00Z", 51.4779, 90.0 - 51.4779 + 23.436),
        ("2024-12-21T11:58:00Z", 51.4779, 90.0 - 51.4779 - 23.438),
        ("2024-06-20T12:02:00Z", -33.0, 90.0 - 33.0 - 23.436),
        ("2024-06-20T12:00:00Z", 90.0, 23.436),
    ] {
        let found = position(&sea(latitude, 0.0), at(noon), None).unwrap();
        assert!((found.elevation_degrees - height).abs() < 0.01, "{noon}, {latitude}: {found:?}");
    }
}

/// Sunrise and sunset in London on 21 June are at 4:43 and 21:21 BST (USNO). By definition the sun's centre,
/// without refraction, is then 50' below the horizon. In a minute it moves by 0.12°.
#[test]
fn position_at_sunrise_and_sunset_is_50_minutes_below_the_horizon() {
    for (time, azimuth) in [("2024-06-21T03:43:00Z", 49.0), ("2024-06-21T20:21:00Z", 311.0)] {
        let found = position(&sea(51.507, -0.128), at(time), None).unwrap();
        assert!((found.elevation_degrees + 50.0 / 60.0).abs() < 0.12, "{time}: {found:?}");
        assert!((found.azimuth_degrees - azimuth).abs() < 0.5, "{time}: {found:?}");
    }
}

#[test]
fn refraction_is_largest_at_the_horizon() {
    let location = sea(51.507, -0.128);
    let lift = |time: &str| {
        let of = |air| position(&location, at(time), air).unwrap().elevation_degrees;
        of(Some(&Atmosphere::STANDARD)) - of(None)
    };
    let (low, high) = (lift("2024-06-21T03:50:00Z"), lift("2024-06-21T12:00:00Z"));
    assert!((0.3..0.6).contains(&low) && (0.0..0.02).contains(&high), "{low} {high}");
}

#[test]
fn position_gives_a_sun_only_above_the_horizon() {
    let location = sea(0.0, 0.0);
    assert!(position(&location, at("2024-03-20T00:00:00Z"), None).unwrap().sun().is_none());
    let noon = position(&location, at("2024-03-20T12:07:00Z"), None).unwrap().sun().unwrap();
    assert!(noon.towards()[1] > 0.999);
    let zenith = Position { azimuth_degrees: 0.0, elevation_degrees: 90.0 };
    assert_eq!(zenith.towards(), [0.0, 1.0, 0.0]);
    assert!(Position { azimuth_degrees: 0.0, elevation_degrees: 0.0 }.sun().is_none());
    // In the morning the sun is in the east, which is +X.
    let morning = position(&location, at("2024-03-20T08:00:00Z"), None).unwrap().sun().unwrap();
    assert!(morning.towards()[0] > 0.8);
}

#[test]
fn rejects_times_and_atmospheres_out_of_range() {
    let location = sea(0.0, 0.0);
    for seconds in [-1e12, 1e12, f64::NAN, f64::INFINITY] {
        assert!(matches!(position(&location, seconds, None), Err(Error::DateRange { .. })), "{seconds}");
    }
    let vacuum = Atmosphere { pressure_hpa: 0.0, temperature_celsius: 0.0 };
    assert!(matches!(position(&location, 0.0, Some(&vacuum)), Err(Error::Range { .. })));
}
