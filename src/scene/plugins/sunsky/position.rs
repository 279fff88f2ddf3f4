//! Position of the sun at a place and a time (Blanco-Muriel et al. 2001, "Computing the solar vector").

use glam::{DVec3, dvec3};

/// Place on Earth, and a local time there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PlaceAndTime {
    /// Degrees north.
    pub latitude: f64,
    /// Degrees east.
    pub longitude: f64,
    /// Hours of the local time before Greenwich's.
    pub timezone: f64,
    pub year: i64,
    pub month: i64,
    pub day: i64,
    /// Hours since midnight, with fractions.
    pub hours: f64,
}

/// Noon of 1 January 2000 as a Julian day.
const EPOCH: f64 = 2_451_545.0;
/// Radius of the Earth over its distance from the sun.
const PARALLAX: f64 = 6371.01 / 149_597_890.0;

/// Unit direction to the sun: `+x` is south, `+y` west, `+z` up.
pub(super) fn sun_direction(at: &PlaceAndTime) -> DVec3 {
    let hours = at.hours - at.timezone;
    let days = julian_day(at.year, at.month, at.day) - 0.5 + hours / 24.0 - EPOCH;
    let omega = 2.1429 - 0.0010394594 * days;
    let mean_longitude = 4.8950630 + 0.017202791698 * days;
    let anomaly = 6.2400600 + 0.0172019699 * days;
    let longitude = mean_longitude + 0.03341607 * anomaly.sin() + 0.00034894 * (2.0 * anomaly).sin()
        - 0.0001134
        - 0.0000203 * omega.sin();
    let obliquity = 0.4090928 - 6.2140e-9 * days + 0.0000396 * omega.cos();
    let right_ascension = (obliquity.cos() * longitude.sin()).atan2(longitude.cos());
    let declination = (obliquity.sin() * longitude.sin()).asin();
    let sidereal_hours = 6.6974243242 + 0.0657098283 * days + hours;
    let hour_angle = (15.0 * sidereal_hours + at.longitude).to_radians() - right_ascension;
    let latitude = at.latitude.to_radians();
    let height = latitude.cos() * hour_angle.cos() * declination.cos() + declination.sin() * latitude.sin();
    let angle = height.clamp(-1.0, 1.0).acos();
    let from_zenith = angle + PARALLAX * angle.sin();
    let azimuth = (-hour_angle.sin()).atan2(declination.tan() * latitude.cos() - latitude.sin() * hour_angle.cos());
    let (sine, cosine) = from_zenith.sin_cos();
    dvec3(-sine * azimuth.cos(), -sine * azimuth.sin(), cosine)
}

/// Julian day that begins at noon of a day of the Gregorian calendar (Fliegel and Van Flandern 1968).
fn julian_day(year: i64, month: i64, day: i64) -> f64 {
    let shift = (month - 14) / 12;
    let days = (1461 * (year + 4800 + shift)) / 4 + (367 * (month - 2 - 12 * shift)) / 12
        - (3 * ((year + 4900 + shift) / 100)) / 4
        + day
        - 32075;
    days as f64
}

#[test]
fn the_epoch_is_the_day_of_its_name() {
    assert_eq!(julian_day(2000, 1, 1), EPOCH);
    assert_eq!(julian_day(2024, 3, 1) - julian_day(2024, 2, 28), 2.0);
}
