//! Dates in headers of files.

use std::ops::RangeInclusive;
use std::time::{SystemTime, UNIX_EPOCH};

use crate::{Error, Result};

/// Name of the environment variable that replaces the present time, in seconds since 1970, so that work can be repeated with the
/// same result (reproducible-builds.org).
const SOURCE_DATE_EPOCH: &str = "SOURCE_DATE_EPOCH";
const SECONDS_PER_DAY: i64 = 86_400;
/// Seconds since 1970 of the years 0 to 9999, which the form of a date can hold.
const SECONDS: RangeInclusive<i64> = -62_167_219_200..=253_402_300_799;

/// Present time in UTC, as `YYYY:MM:DD hh:mm:ss`.
///
/// # Errors
/// Where the time is fixed to something else than a whole number of seconds in the years 0 to 9999.
pub(super) fn now() -> Result<String> {
    let seconds = match std::env::var_os(SOURCE_DATE_EPOCH) {
        Some(text) => fixed(&text.to_string_lossy())?,
        None => SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs() as i64),
    };
    Ok(date(seconds))
}

/// A fixed time in seconds since 1970.
fn fixed(text: &str) -> Result<i64> {
    text.trim().parse().ok().filter(|seconds| SECONDS.contains(seconds)).ok_or_else(|| {
        Error::Settings(format!(
            "{SOURCE_DATE_EPOCH} is {text:?}, but must be a whole number of seconds since 1970, within the years 0 to 9999"
        ))
    })
}

/// Date and time in UTC of a number of seconds since 1970.
fn date(seconds: i64) -> String {
    let (days, rest) = (seconds.div_euclid(SECONDS_PER_DAY), seconds.rem_euclid(SECONDS_PER_DAY));
    let (hour, minute, second) = (rest / 3600, rest / 60 % 60, rest % 60);
    let (year, month, day) = civil(days);
    format!("{year:04}:{month:02}:{day:02} {hour:02}:{minute:02}:{second:02}")
}

/// Year, month and day of a number of days since 1970-01-01 in the Gregorian calendar (Hinnant, "chrono-Compatible Low-Level
/// Date Algorithms"). Years begin in March there, so that a leap day is the last day.
fn civil(days: i64) -> (i64, i64, i64) {
    // 400 years have 146,097 days.
    let days = days + 719_468;
    let (era, day_of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    (era * 400 + year_of_era + i64::from(month <= 2), month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, expected) in [
            (*SECONDS.start(), "0000:01:01 00:00:00"),
            (-1, "1969:12:31 23:59:59"),
            (0, "1970:01:01 00:00:00"),
            (951_782_399, "2000:02:28 23:59:59"),
            (951_782_400, "2000:02:29 00:00:00"),
            (951_868_800, "2000:03:01 00:00:00"),
            (1_709_210_096, "2024:02:29 12:34:56"),
            (4_107_542_400, "2100:03:01 00:00:00"),
            (*SECONDS.end(), "9999:12:31 23:59:59"),
        ] {
            assert_eq!(date(seconds), expected);
            assert_eq!(fixed(&seconds.to_string()).unwrap(), seconds);
        }
    }

    #[test]
    fn what_is_no_date_is_refused() {
        for text in ["", "now", "1.5", "0x10", "253402300800", "-62167219201", "99999999999999999999"] {
            let error = fixed(text).unwrap_err().to_string();
            assert!(error.starts_with("SOURCE_DATE_EPOCH is ") && error.contains("years 0 to 9999"), "{error}");
        }
    }

    /// Every day of 400 years follows the day before.
    #[test]
    fn days_follow_each_other() {
        let mut before = civil(0);
        for day in 1..146_097 {
            let next = civil(day);
            let follows = match next {
                (year, 1, 1) => before == (year - 1, 12, 31),
                (year, month, 1) => before.0 == year && before.1 == month - 1 && before.2 >= 28,
                (year, month, day) => before == (year, month, day - 1),
            };
            assert!(follows && next.2 <= 31, "{before:?} and {next:?}");
            before = next;
        }
        assert_eq!(before, (2369, 12, 31));
    }
}
