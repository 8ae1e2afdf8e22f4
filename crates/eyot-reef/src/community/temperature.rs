//! Sea temperatures as text: a table of days or of months.

use super::parameters::bad;
use eyot_core::Result;

/// Days of the months; February has 28 days, the 29th counts as the 28th.
pub(crate) const MONTH_DAYS: [usize; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
/// Days of a year.
pub(crate) const YEAR_DAYS: usize = 365;
/// Longest series, days: 10000 years.
const MAX_DAYS: usize = 10_000 * YEAR_DAYS;

/// Temperatures of the sea, one for each day of whole months; February 29th is left out.
#[derive(Clone, Debug, PartialEq)]
pub struct Temperatures {
    /// Month of the year of the first day, 0 to 11.
    pub first_month: usize,
    /// Temperatures, C.
    pub days: Vec<f32>,
}

/// A line's date: year, month 0..=11, day 1..=31 or none in tables of months.
type Date = (i64, usize, Option<usize>);

impl Temperatures {
    /// Reads a table of two columns, date and temperature in C, separated by semicolon, tab, comma or space. Dates are
    /// `2005-08-31` in tables of days and `2005-08` in tables of months. A first line without a date is a heading; empty lines
    /// and those that begin with `#` count for nothing.
    ///
    /// Months become 28 to 31 equal days. Where days are missing - no line, no number, `nan`, or exactly 0, with which loggers
    /// mark a gap - the line between their neighbours is taken; with `gaps_are_cold` such days have 0 C, as in the original
    /// program.
    ///
    /// # Errors
    /// A line that cannot be read, with its number; dates that do not rise; temperatures outside -5..=50 C; less than a month of
    /// data.
    pub fn parse(text: &str, gaps_are_cold: bool) -> Result<Self> {
        let mut rows: Vec<(usize, Date, Option<f32>)> = Vec::new();
        for (i, line) in text.lines().enumerate() {
            let line = line.trim().trim_start_matches('\u{feff}');
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let mut cells = columns(line).into_iter();
            let first = cells.next().unwrap_or_default().trim_matches('"');
            let Some(date) = date(first) else {
                if rows.is_empty() && !first.starts_with(|c: char| c.is_ascii_digit()) {
                    continue;
                }
                return Err(at(i, format!("`{}` is no date such as 2005-08-31 or 2005-08", shown(first))));
            };
            let value = temperature(cells.next().unwrap_or_default().trim_matches('"')).map_err(|e| at(i, e))?;
            if let Some(more) = cells.next() {
                return Err(at(i, format!("`{}` is one column too many; give a date and a temperature", shown(more))));
            }
            if let Some((_, before, _)) = rows.last() {
                if before.2.is_some() != date.2.is_some() {
                    return Err(at(i, "days and months are mixed; give either".into()));
                }
                if *before >= date {
                    return Err(at(i, "dates must rise from line to line".into()));
                }
            }
            rows.push((i, date, value));
        }
        Self::of_rows(&rows, gaps_are_cold)
    }

    fn of_rows(rows: &[(usize, Date, Option<f32>)], gaps_are_cold: bool) -> Result<Self> {
        let (Some(&(_, (year, first_month, _), _)), Some(&(line, (last_year, last_month, _), _))) =
            (rows.first(), rows.last())
        else {
            return Err(bad("temperatures", "text", "holds no line with a date and a temperature".into()));
        };
        let start = day_number(year, first_month, 1);
        let days = day_number(last_year, last_month, 1) - start + MONTH_DAYS[last_month] as i64;
        if days > MAX_DAYS as i64 {
            return Err(at(line, format!("{} years from the first line; 10000 are allowed", last_year - year)));
        }
        let mut known: Vec<Option<f32>> = vec![None; days as usize];
        for &(_, (year, month, day), value) in rows {
            let from = (day_number(year, month, day.unwrap_or(1)) - start) as usize;
            let count = if day.is_some() { 1 } else { MONTH_DAYS[month] };
            known[from..from + count].fill(value);
        }
        if known.iter().all(Option::is_none) {
            return Err(bad("temperatures", "text", "holds no temperature".into()));
        }
        let days = if gaps_are_cold { known.iter().map(|v| v.unwrap_or(0.0)).collect() } else { bridged(&known) };
        Ok(Self { first_month, days })
    }

    /// The series of twelve mean temperatures (C) over so many years, on straight lines between the middles of months, of which
    /// each month keeps its mean within 0.01 C.
    pub fn of_climate(means: &[f32; 12], years: usize) -> Self {
        let line = |values: &[f32; 12]| -> Vec<f32> {
            let mut days = Vec::with_capacity(YEAR_DAYS);
            for m in 0..12 {
                for d in 0..MONTH_DAYS[m] {
                    let t = (d as f32 + 0.5) / MONTH_DAYS[m] as f32 - 0.5;
                    let other = values[if t < 0.0 { (m + 11) % 12 } else { (m + 1) % 12 }];
                    days.push(values[m] + (other - values[m]) * t.abs());
                }
            }
            days
        };
        let mut middles = *means;
        for _ in 0..8 {
            let got = monthly_means(&line(&middles));
            middles = std::array::from_fn(|m| middles[m] + means[m] - got[m]);
        }
        let year = line(&middles);
        Self { first_month: 0, days: year.iter().copied().cycle().take(YEAR_DAYS * years).collect() }
    }

    /// Whole months.
    pub fn months(&self) -> usize {
        let mut left = self.days.len();
        let mut n = 0;
        while left >= MONTH_DAYS[(self.first_month + n) % 12] {
            left -= MONTH_DAYS[(self.first_month + n) % 12];
            n += 1;
        }
        n
    }

    /// Mean of the warmest month of the mean year, C.
    pub fn warmest_month(&self) -> f32 {
        let (mut sum, mut count) = ([0.0f64; 12], [0u32; 12]);
        let mut from = 0;
        for n in 0..self.months() {
            let m = (self.first_month + n) % 12;
            sum[m] += self.days[from..from + MONTH_DAYS[m]].iter().map(|&t| f64::from(t)).sum::<f64>();
            count[m] += MONTH_DAYS[m] as u32;
            from += MONTH_DAYS[m];
        }
        let means = (0..12).filter(|&m| count[m] > 0).map(|m| (sum[m] / f64::from(count[m])) as f32);
        means.fold(f32::NEG_INFINITY, f32::max)
    }
}

fn monthly_means(year: &[f32]) -> [f32; 12] {
    let mut from = 0;
    MONTH_DAYS.map(|n| {
        from += n;
        year[from - n..from].iter().sum::<f32>() / n as f32
    })
}

/// Days since the year 0 in years of 365 days.
fn day_number(year: i64, month: usize, day: usize) -> i64 {
    let before: usize = MONTH_DAYS[..month].iter().sum();
    year * YEAR_DAYS as i64 + (before + day.min(MONTH_DAYS[month])) as i64
}

fn date(text: &str) -> Option<Date> {
    // What follows a date is a time of day.
    let text = text.split('T').next()?;
    let mut parts = text.split(['-', '/']);
    let year = parts.next().filter(|y| y.len() == 4)?.parse::<u16>().ok()?;
    let month = parts.next()?.parse::<usize>().ok().filter(|m| (1..=12).contains(m))? - 1;
    let longest = MONTH_DAYS[month] + usize::from(month == 1);
    let day = match parts.next() {
        None => None,
        Some(d) => Some(d.parse::<usize>().ok().filter(|d| (1..=longest).contains(d))?),
    };
    parts.next().is_none().then_some((i64::from(year), month, day))
}

/// None for a gap.
/// Cells of a line; empty ones at its end do not count. A semicolon or a tab divides before a comma does, and that before a space.
fn columns(line: &str) -> Vec<&str> {
    let cells: Vec<&str> = match [';', '\t', ','].into_iter().find(|&c| line.contains(c)) {
        Some(mark) => line.split(mark).map(str::trim).collect(),
        None => line.split_whitespace().collect(),
    };
    let end = cells.iter().rposition(|c| !c.is_empty()).map_or(0, |last| last + 1);
    cells[..end].to_vec()
}

fn temperature(text: &str) -> Result<Option<f32>, String> {
    if text.is_empty() || text.eq_ignore_ascii_case("nan") || text.eq_ignore_ascii_case("na") {
        return Ok(None);
    }
    let value: f32 = text.parse().map_err(|_| match text.replace(',', ".").parse::<f32>() {
        Ok(point) => format!("`{}` has a comma; write {point}", shown(text)),
        Err(_) => format!("`{}` is no temperature", shown(text)),
    })?;
    if value == 0.0 {
        return Ok(None);
    }
    if (-5.0..=50.0).contains(&value) { Ok(Some(value)) } else { Err(format!("{value} C is outside -5..=50 C")) }
}

/// Straight lines over the gaps; before the first value and after the last one these.
fn bridged(known: &[Option<f32>]) -> Vec<f32> {
    let mut days: Vec<f32> = known.iter().map(|v| v.unwrap_or(f32::NAN)).collect();
    let mut last: Option<usize> = None;
    for i in 0..days.len() {
        if days[i].is_nan() {
            continue;
        }
        let value = days[i];
        match last {
            None => days[..i].fill(value),
            Some(j) => {
                let step = (value - days[j]) / (i - j) as f32;
                (j + 1..i).for_each(|k| days[k] = days[j] + step * (k - j) as f32);
            }
        }
        last = Some(i);
    }
    if let Some(j) = last {
        let value = days[j];
        days[j + 1..].fill(value);
    }
    days
}

fn at(line: usize, reason: String) -> eyot_core::Error {
    bad("temperatures", &format!("line {}", line + 1), reason)
}

/// The beginning of a text that a message quotes.
fn shown(text: &str) -> String {
    text.chars().take(20).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_days_and_months_are_read() {
        let days =
            Temperatures::parse("date,sst\n# Chumbe\n2004-02-27, 28.5\n2004-02-29;29.5\n2004-03-02 0.00\n", false)
                .unwrap();
        assert_eq!((days.first_month, days.days.len(), days.months()), (1, 59, 2));
        // 29 February counts as the 28th; what is not there is taken from its neighbours.
        assert_eq!((days.days[0], days.days[26], days.days[27], days.days[58]), (28.5, 28.5, 29.5, 29.5));
        let cold = Temperatures::parse("2004-02-27 28.5\n2004-02-28 0.00\n", true).unwrap();
        assert_eq!((cold.days[26], cold.days[27], cold.days[0]), (28.5, 0.0, 0.0));
        let bridge = Temperatures::parse("2004-01-01 20\n2004-01-31T12:00:00 26", false).unwrap();
        assert_eq!((bridge.days[15], bridge.days[10]), (23.0, 22.0));
        let months = Temperatures::parse("\u{feff}month;sst\n2004-12;28\n2005-01;nan\n2005-02;29\n", false).unwrap();
        assert_eq!((months.first_month, months.days.len(), months.months()), (11, 90, 3));
        assert!(months.days[31] > 28.0 && months.days[61] < 29.0);
    }

    #[test]
    fn bad_tables_are_refused_with_the_line() {
        for (text, part) in [
            ("", "no line"),
            ("date,sst\n", "no line"),
            ("2004-13-01,28", "line 1"),
            ("2004-01-01,28\n2004-01-01,28", "line 2: dates must rise"),
            ("2004-01-01,28\n2004-02,28", "mixed"),
            ("2004-01-01,280", "outside"),
            ("2004-01-01,warm", "no temperature"),
            ("2004-01-01,inf", "outside"),
            ("2004-01-01,nan", "holds no temperature"),
            ("2004-02-30,28", "no date"),
            ("0000-01,28\n9999-12,28\n", ""),
        ] {
            let got = Temperatures::parse(text, false);
            match part {
                "" => assert_eq!(got.unwrap().months(), 120_000),
                part => assert!(got.as_ref().unwrap_err().to_string().contains(part), "{text:?}: {got:?}"),
            }
        }
    }

    #[test]
    fn a_climate_keeps_its_monthly_means() {
        let means = [28.27, 28.37, 28.89, 28.51, 27.87, 26.84, 25.85, 25.25, 25.40, 26.04, 27.34, 28.44];
        let series = Temperatures::of_climate(&means, 2);
        assert_eq!((series.days.len(), series.months()), (730, 24));
        for (got, want) in monthly_means(&series.days[..365]).iter().zip(means) {
            assert!((got - want).abs() < 0.01, "{got} {want}");
        }
        assert!((series.warmest_month() - 28.89).abs() < 0.01);
    }
}
