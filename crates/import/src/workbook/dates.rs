//! Days as workbooks count them, as text (ISO 8601).

/// Days from 0000-03-01 to the day 0 of a count: 1899-12-30, with which 1900-03-01 is day 61 as
/// Excel has it, or 1904-01-01.
const DAY_0: i64 = 693_899;
const DAY_0_OF_1904: i64 = 695_361;
/// Days from 0000-03-01 to the first that ISO 8601 cannot write: 10000-01-01.
const DAYS: i64 = 3_652_365;
const MILLISECONDS: f64 = 86_400_000.0;

/// `2026-01-31`, `2026-01-31T12:00:00`, or below one day `12:00:00`; seconds to the millisecond. None
/// for a day before the count or after the year 9999.
#[allow(clippy::cast_possible_truncation)] // The range is checked.
pub(super) fn iso(days: f64, since_1904: bool) -> Option<String> {
    if !(0.0..DAYS as f64).contains(&days) {
        return None;
    }
    let milliseconds = (days * MILLISECONDS).round() as i64;
    // Only the rounded time says which day it is: a moment before midnight may be that of the next.
    let day = milliseconds / 86_400_000;
    let rest = milliseconds % 86_400_000;
    let day_0 = if since_1904 { DAY_0_OF_1904 } else { DAY_0 };
    if day_0 + day >= DAYS {
        return None;
    }
    let hours = rest / 3_600_000;
    let minutes = rest / 60_000 % 60;
    let seconds = rest / 1000 % 60;
    let fraction = rest % 1000;
    let mut time = format!("{hours:02}:{minutes:02}:{seconds:02}");
    if fraction > 0 {
        time += &format!(".{fraction:03}");
    }
    if day == 0 {
        return Some(time);
    }
    let date = date(day_0 + day);
    Some(if rest == 0 { date } else { format!("{date}T{time}") })
}

/// The date so many days after 0000-03-01 of the Gregorian calendar. Years are counted from March,
/// so that a leap day ends one.
fn date(days: i64) -> String {
    let era = days / 146_097;
    let day = days % 146_097;
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    // Months from March have 31, 30, 31, 30, 31 days, twice and once more.
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let year = year + 400 * era;
    let month = month + 3;
    let (year, month) = if month > 12 { (year + 1, month - 12) } else { (year, month) };
    format!("{year:04}-{month:02}-{day:02}")
}

/// Whether a number in this format is a date or a time: letters of either outside of quotes and
/// brackets.
pub(super) fn is_date(format: &str) -> bool {
    let mut quoted = false;
    let mut bracket = String::new();
    let mut escaped = false;
    let mut in_bracket = false;
    for letter in format.chars().map(|letter| letter.to_ascii_lowercase()) {
        match letter {
            _ if escaped => escaped = false,
            '"' if !in_bracket => quoted = !quoted,
            _ if quoted => {}
            '\\' | '_' | '*' => escaped = true,
            '[' => in_bracket = true,
            // Hours, minutes or seconds that pass 24 or 60 stand in brackets, and so do colours and
            // places.
            ']' => {
                if !bracket.is_empty() && bracket.chars().all(|c| ['h', 'm', 's'].contains(&c)) {
                    return true;
                }
                (in_bracket, bracket) = (false, String::new());
            }
            letter if in_bracket => bracket.push(letter),
            'y' | 'm' | 'd' | 'h' | 's' => return true,
            // Behind it stand the formats of negative numbers, zero and texts.
            ';' => return false,
            _ => {}
        }
    }
    false
}

/// Whether the number of a format that every workbook knows is one of dates or times.
pub(super) fn is_date_number(format: usize) -> bool {
    matches!(format, 14..=22 | 27..=36 | 45..=47 | 50..=58)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn days_become_dates_and_times() {
        let check = |days, expect: &str| assert_eq!(iso(days, false).as_deref(), Some(expect));
        check(61.0, "1900-03-01");
        check(45_351.0, "2024-02-29");
        check(45_352.25, "2024-03-01T06:00:00");
        check(0.5 + 1.234 / 86_400.0, "12:00:01.234");
        check(2_958_465.0, "9999-12-31");
        assert_eq!(iso(1.0, true).as_deref(), Some("1904-01-02"));
        for none in [-1.0, f64::NAN, 1e300, 2_958_466.0] {
            assert_eq!(iso(none, false), None);
        }
    }

    #[test]
    fn no_day_is_after_the_year_9999_and_none_has_24_hours() {
        let last_moment = 2_958_465.0 + 86_399_999.0 / MILLISECONDS;
        assert_eq!(iso(last_moment, false).as_deref(), Some("9999-12-31T23:59:59.999"));
        // The next number below that of the year 10000 is less than a millisecond before it.
        assert_eq!(iso(2_958_466_f64.next_down(), false), None);
        assert_eq!(iso(2_957_003.0, true).as_deref(), Some("9999-12-31"));
        for none in [2_957_004.0, 2_958_465.0, 2_957_004_f64.next_down(), f64::INFINITY] {
            assert_eq!(iso(none, true), None, "{none}");
        }
        assert_eq!(iso(1_f64.next_down(), false).as_deref(), Some("1899-12-31"));
        assert_eq!(iso(62_f64.next_down(), false).as_deref(), Some("1900-03-02"));
        for number in 0..=9_999 {
            let days = f64::from(number) * 296.3 + 0.999_999_999_9;
            for text in [false, true].map(|since_1904| iso(days, since_1904)).into_iter().flatten()
            {
                let (date, time) = text.split_once('T').unwrap_or((&text, "00:00:00"));
                assert!(date.len() == 10 && time < "24", "{days}: {text}");
            }
        }
    }

    #[test]
    fn formats_of_dates_are_told_from_those_of_numbers() {
        for date in ["yyyy-mm-dd", "[h]:mm:ss", "[$-409]m/d/yy", "mm:ss.0", "\"at\" h"] {
            assert!(is_date(date), "{date}");
        }
        for number in ["General", "0.00", "0.0\" days\"", "[Red]0.00;[Blue]-0", "#,##0\\d", "0_d"] {
            assert!(!is_date(number), "{number}");
        }
    }
}
