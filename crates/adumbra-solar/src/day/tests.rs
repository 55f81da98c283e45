//! Days with daylight-saving time, nights, poles and midnights.

use super::*;

fn day(rest: &str) -> Day {
    format!("lat=52.52,lon=13.4,{rest}").parse().unwrap()
}

/// Hours between the ends, and the clock at each.
fn span(day: &Day) -> (f64, [String; 2]) {
    let ends = day.ends().unwrap().map(|end| end as f64);
    ((ends[1] - ends[0]) / 3600.0, ends.map(|end| day.zone().clock(end)))
}

#[test]
fn day_has_a_step_for_each_minute_and_both_ends() {
    let steps = day("date=2026-06-21,from=7,to=19,tz=Europe/Berlin").steps().unwrap();
    assert_eq!(steps.len(), 721);
    // 7:00 CEST is 5:00Z.
    assert_eq!([steps[0].unix_seconds, steps[720].unix_seconds], [1_782_018_000.0, 1_782_061_200.0]);
    assert!(steps.iter().all(|step| step.sun.is_some()));
    assert!(steps.windows(2).all(|w| w[1].unix_seconds - w[0].unix_seconds == 60.0));
    // The last step is shorter if the span is not a whole number of steps.
    let steps = day("date=2026-06-21,from=7,to=7:05,step=120").steps().unwrap();
    let seconds: Vec<f64> = steps.iter().map(|step| step.unix_seconds - steps[0].unix_seconds).collect();
    assert_eq!(seconds, [0.0, 120.0, 240.0, 300.0]);
}

#[test]
fn day_is_read_by_the_clock_of_its_zone() {
    let offset = day("date=2026-06-21,from=7,to=19,tz=+02:00");
    let berlin = day("date=2026-06-21,from=7,to=19,tz=Europe/Berlin");
    assert_eq!(offset.ends(), berlin.ends());
    // At sea 13.4° east is one hour before UTC.
    let at_sea = day("date=2026-06-21,from=6,to=18");
    assert_eq!(at_sea.ends(), berlin.ends());
    assert_eq!(at_sea.zone().name(), "+01:00");
}

#[test]
fn day_may_pass_midnight_and_last_24_hours() {
    let of = |rest: &str| span(&day(&format!("date=2026-06-21,tz=Europe/Berlin,{rest}")));
    assert_eq!(of("from=22,to=2"), (4.0, ["22:00".to_owned(), "02:00".to_owned()]));
    assert_eq!(of("from=0,to=24"), (24.0, ["00:00".to_owned(), "00:00".to_owned()]));
    assert_eq!(of("from=12,to=11:59").0, 24.0 - 1.0 / 60.0);
    let last = day("date=2026-12-31,from=20,to=24,tz=UTC");
    assert_eq!(last.ends().unwrap()[1], 1_798_761_600);
}

#[test]
fn day_length_follows_skipped_and_repeated_hours() {
    let spring = |rest: &str| day(&format!("date=2026-03-29,tz=Europe/Berlin,{rest}"));
    let autumn = |rest: &str| day(&format!("date=2026-10-25,tz=Europe/Berlin,{rest}"));
    assert_eq!(span(&spring("from=0,to=24")).0, 23.0);
    assert_eq!(span(&autumn("from=0,to=24")).0, 25.0);
    // 2:30 is skipped, and read as 3:30.
    assert_eq!(span(&spring("from=2:30,to=5")), (1.5, ["03:30".to_owned(), "05:00".to_owned()]));
    assert_eq!(span(&spring("from=1,to=2:30")), (1.5, ["01:00".to_owned(), "03:30".to_owned()]));
    assert!(matches!(spring("from=2:30,to=3:10").ends(), Err(Error::EmptySpan { .. })));
    // 2:00 to 3:00 is shown twice.
    assert_eq!(span(&autumn("from=2:30,to=5")).0, 3.5);
    assert_eq!(span(&autumn("from=1,to=2:30")).0, 2.5);
    assert_eq!(span(&autumn("from=2:15,to=2:45")).0, 1.5);
}

#[test]
fn rejects_day_with_empty_span_or_bad_step() {
    let error = day("date=2026-06-21,from=7,to=7").ends().unwrap_err();
    assert!(error.to_string().contains("24 for the end of the day"), "{error}");
    assert!(matches!(
        day("date=2026-10-25,from=2:30,to=2:30,tz=Europe/Berlin").ends(),
        Err(Error::EmptySpan { .. })
    ));
    assert!(matches!(day("date=2026-06-21,from=24,to=2").ends(), Err(Error::Range { field: "start", .. })));
    let none = Day { step_seconds: 0, ..day("date=2026-06-21,from=7,to=8") };
    assert!(matches!(none.steps(), Err(Error::Range { field: "step", .. })));
}

#[test]
fn polar_night_has_no_sun_and_polar_day_no_night() {
    let at = |text: &str| text.parse::<Day>().unwrap().steps().unwrap();
    let up = |steps: &[SunStep]| steps.iter().filter(|step| step.sun.is_some()).count();
    let tromso = |date: &str| at(&format!("lat=69.65,lon=18.96,date={date},from=0,to=24,tz=Europe/Oslo"));
    let (night, day) = (tromso("2026-12-21"), tromso("2026-06-21"));
    assert_eq!((night.len(), up(&night)), (1441, 0));
    assert_eq!((day.len(), up(&day)), (1441, 1441));
    for latitude in [90, -90] {
        let pole = at(&format!("lat={latitude},lon=0,date=2026-06-21,from=0,to=24,step=3600"));
        let elevation = pole[0].position.elevation_degrees;
        assert!((elevation.abs() - 23.44).abs() < 0.1, "{elevation}");
        // The sun circles at constant elevation, westwards as seen from the north. The azimuth is always
        // defined.
        assert!(pole.iter().all(|s| (s.position.elevation_degrees - elevation).abs() < 0.01));
        let turned = pole[1].position.azimuth_degrees - pole[0].position.azimuth_degrees;
        assert!((turned.abs() - 15.0).abs() < 0.01 || (turned.abs() - 345.0).abs() < 0.01, "{turned}");
    }
}

#[test]
fn sun_is_lower_without_refraction() {
    let of = |rest: &str| day(&format!("date=2026-12-21,from=9,to=10{rest}")).steps().unwrap()[0];
    let (air, none) = (of(""), of(",refraction=off"));
    assert!(air.position.elevation_degrees > none.position.elevation_degrees + 0.05);
    assert_eq!(air.position.azimuth_degrees, none.position.azimuth_degrees);
}
