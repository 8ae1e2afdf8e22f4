//! Units of the living world, and the affine maps from the abstract numbers in which its source gives them.
//!
//! | abstract | physical | why |
//! |---|---|---|
//! | temperature `T`, -1..=1 | `12 + 24 T` degrees Celsius | the source's zones then end at 12, 18 and 24 degrees, as Holdridge's do |
//! | humidity, 0..=1 | `2500 q` mm of rain a year | its driest zones then end at 250 mm, its wettest begin at 2000 mm |
//! | height, units | `1000 (g - 0.95)` m above the sea | 0.95 is the source's level of the sea |
//! | wind, -1..=1 | `10 w` m/s | a fresh breeze |
//!
//! The layers hold physical values, and so do all parameters that are temperatures, heights or lengths of time.
//! Parameters that are weights keep the numbers of the source.

use eyot_core::Grid;

/// Degrees Celsius of the abstract temperature 0.
pub const CELSIUS_AT_ZERO: f32 = 12.0;
/// Degrees Celsius of a unit of abstract temperature.
pub const CELSIUS_PER_UNIT: f32 = 24.0;
/// Rain of a unit of abstract humidity, mm a year.
pub const MM_PER_HUMIDITY: f32 = 2500.0;
/// Metres of a unit of abstract height.
pub const METRES_PER_UNIT: f32 = 1000.0;
/// Level of the sea in abstract height.
pub const SEA_UNITS: f32 = 0.95;
/// Wind of abstract strength 1, and the strongest there is, m/s.
pub const FULL_WIND: f32 = 10.0;
/// Cells that the strongest wind crosses in a step. Four faces of them empty no cell.
pub const FULL_WIND_CELLS: f32 = 0.2;
/// Time in which saturated air rains two thirds of what it holds, h.
pub const RAIN_HOURS: f32 = 57.0;
/// Hours in the year that rain is given for.
pub const HOURS_PER_YEAR: f32 = 8766.0;
/// Depth of the water in a column of air whose humidity is 1, m.
pub const AIR_WATER: f32 = 0.0325;

/// Years of rain, rivers, ice and sand in an hour of weather: what the ground does is 18 times faster, so that rivers
/// have found their way after some years of weather. Much faster, and water would stand wherever a river has to carry
/// much of it.
pub const GROUND_YEARS_PER_HOUR: f32 = 0.002;

/// Degrees Celsius from an abstract temperature.
pub fn celsius(abstract_temperature: f32) -> f32 {
    CELSIUS_AT_ZERO + CELSIUS_PER_UNIT * abstract_temperature
}

/// Abstract temperature from degrees Celsius.
pub fn abstract_temperature(celsius: f32) -> f32 {
    (celsius - CELSIUS_AT_ZERO) / CELSIUS_PER_UNIT
}

/// Millimetres of rain a year from an abstract humidity.
pub fn mm_per_year(humidity: f32) -> f32 {
    MM_PER_HUMIDITY * humidity
}

/// Metres above the source's sea from an abstract height.
pub fn metres(units: f32) -> f32 {
    METRES_PER_UNIT * (units - SEA_UNITS)
}

/// Hours of weather in a step: what the strongest wind needs for [`FULL_WIND_CELLS`] of the shorter side of a cell. A
/// finer grid takes shorter steps, so that the climate stays the same.
pub fn hours_per_step(grid: &Grid) -> f64 {
    f64::from(FULL_WIND_CELLS) * grid.cell_x_m.min(grid.cell_y_m) / f64::from(FULL_WIND) / 3600.0
}

/// Years of rain, rivers, ice and sand in a step.
pub fn ground_years_per_step(grid: &Grid) -> f64 {
    f64::from(GROUND_YEARS_PER_HOUR) * hours_per_step(grid)
}

/// Discharge that moves a metre of depth out of a cell in a step, m3/s.
pub fn discharge_per_metre(grid: &Grid) -> f64 {
    grid.cell_area_m2() / (3600.0 * f64::from(HOURS_PER_YEAR) * ground_years_per_step(grid))
}

#[cfg(test)]
mod tests {
    use super::*;
    use eyot_core::{Boundary, Limits};

    #[test]
    fn the_maps_meet_where_the_documentation_says() {
        assert_eq!([celsius(0.0), celsius(0.25), celsius(0.5), celsius(-1.0)], [12.0, 18.0, 24.0, -12.0]);
        assert!((-50..50).all(|i| (abstract_temperature(celsius(i as f32 * 0.02)) - i as f32 * 0.02).abs() < 1e-6));
        assert_eq!((mm_per_year(0.1), metres(0.95), metres(1.95)), (250.0, 0.0, 1000.0));
        let grid = |n| Grid::new(n, n, 4e7 / n as f64, Boundary::WRAP, &Limits::default()).unwrap();
        assert!((hours_per_step(&grid(512)) / hours_per_step(&grid(1024)) - 2.0).abs() < 1e-12);
    }
}
