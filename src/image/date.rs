//! Dates in headers of files.

use std::time::{SystemTime, UNIX_EPOCH};

/// Name of the environment variable that replaces the present time, in seconds since 1970, so that work can be repeated with the
/// same result (reproducible-builds.org).
const SOURCE_DATE_EPOCH: &str = "SOURCE_DATE_EPOCH";
const SECONDS_PER_DAY: u64 = 86_400;

/// Present time in UTC, as `YYYY:MM:DD hh:mm:ss`.
pub(super) fn now() -> String {
    let fixed = std::env::var(SOURCE_DATE_EPOCH).ok().and_then(|text| text.trim().parse().ok());
    date(fixed.unwrap_or_else(|| SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs())))
}

/// Date and time in UTC of a number of seconds since 1970.
fn date(seconds: u64) -> String {
    let (days, rest) = (seconds / SECONDS_PER_DAY, seconds % SECONDS_PER_DAY);
    let (hour, minute, second) = (rest / 3600, rest / 60 % 60, rest % 60);
    let (year, month, day) = civil(days);
    format!("{year:04}:{month:02}:{day:02} {hour:02}:{minute:02}:{second:02}")
}

/// Year, month and day of a number of days since 1970-01-01 in the Gregorian calendar (Hinnant, "chrono-Compatible Low-Level
/// Date Algorithms"). Years begin in March there, so that a leap day is the last day.
fn civil(days: u64) -> (u64, u64, u64) {
    // 400 years have 146,097 days.
    let days = days.saturating_add(719_468);
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    (era * 400 + year_of_era + u64::from(month <= 2), month, day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        for (seconds, expected) in [
            (0, "1970:01:01 00:00:00"),
            (951_782_399, "2000:02:28 23:59:59"),
            (951_782_400, "2000:02:29 00:00:00"),
            (951_868_800, "2000:03:01 00:00:00"),
            (1_709_210_096, "2024:02:29 12:34:56"),
            (4_107_542_400, "2100:03:01 00:00:00"),
        ] {
            assert_eq!(date(seconds), expected);
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
