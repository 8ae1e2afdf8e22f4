//! The climate classes of Koeppen and Geiger.

use eyot_core::layer::{Class, class};
use eyot_core::real::Real;

/// Names and colours, as Peel and others draw them.
pub const KOEPPEN_CLASSES: &[Class] = &[
    class("ocean", [24, 44, 92]),
    class("Af tropical rainforest", [0, 0, 255]),
    class("Am tropical monsoon", [0, 120, 255]),
    class("Aw tropical savannah", [70, 170, 250]),
    class("BWh hot desert", [255, 0, 0]),
    class("BWk cold desert", [255, 150, 150]),
    class("BSh hot steppe", [245, 165, 0]),
    class("BSk cold steppe", [255, 220, 100]),
    class("Csa dry hot summer", [255, 255, 0]),
    class("Csb dry warm summer", [200, 200, 0]),
    class("Csc dry cold summer", [150, 150, 0]),
    class("Cwa dry winter, hot summer", [150, 255, 150]),
    class("Cwb dry winter, warm summer", [100, 200, 100]),
    class("Cwc dry winter, cold summer", [50, 150, 50]),
    class("Cfa temperate, hot summer", [200, 255, 80]),
    class("Cfb temperate, warm summer", [100, 255, 80]),
    class("Cfc temperate, cold summer", [50, 200, 0]),
    class("Dsa cold, dry hot summer", [255, 0, 255]),
    class("Dsb cold, dry warm summer", [200, 0, 200]),
    class("Dsc cold, dry cold summer", [150, 50, 150]),
    class("Dsd very cold, dry summer", [150, 100, 150]),
    class("Dwa cold, dry winter, hot summer", [170, 175, 255]),
    class("Dwb cold, dry winter, warm summer", [90, 120, 220]),
    class("Dwc cold, dry winter, cold summer", [75, 80, 180]),
    class("Dwd very cold, dry winter", [50, 0, 135]),
    class("Dfa cold, hot summer", [0, 255, 255]),
    class("Dfb cold, warm summer", [55, 200, 255]),
    class("Dfc cold, cold summer", [0, 125, 125]),
    class("Dfd very cold winter", [0, 70, 95]),
    class("ET tundra", [178, 178, 178]),
    class("EF ice", [102, 102, 102]),
];

/// What the criteria ask about the months of a year.
#[derive(Clone, Copy, Debug)]
pub struct Months<R> {
    /// Mean temperature of the year, degrees Celsius.
    pub mean: R,
    /// Mean of the warmest month.
    pub warmest: R,
    /// Mean of the coldest month.
    pub coldest: R,
    /// Mean of the fourth warmest month: at least four are as warm.
    pub fourth: R,
    /// Rain of the year, mm.
    pub rain: R,
    /// Share of it that falls in the warmer half of the year, 0 to 1.
    pub summer_share: R,
    /// Rain of the driest month of the warmer half, mm.
    pub summer_driest: R,
    /// Rain of its wettest month.
    pub summer_wettest: R,
    /// Rain of the driest month of the colder half.
    pub winter_driest: R,
    /// Rain of its wettest month.
    pub winter_wettest: R,
}

impl<R: Real> Months<R> {
    /// The months of a year of which temperature and rain have a mean and one swing each. `warm`: the swing of the
    /// temperature with spring and summer, and its length.
    #[inline(always)]
    pub fn of_harmonics(mean: R, warm: [R; 3], rain: R, wet: [R; 2]) -> Self {
        let zero = R::of(0.0);
        let [warm_cos, warm_sin, swing] = warm;
        // A month's mean has this share of the swing of its middle.
        let flat = R::of(0.988_615_9);
        let wet_swing = (wet[0] * wet[0] + wet[1] * wet[1]).sqrt();
        // The part of the rain's swing that follows the temperature, and the part at right angles to it.
        let per_swing = R::of(1.0) / swing.max(R::of(1e-3));
        let along = (wet[0] * warm_cos + wet[1] * warm_sin) * per_swing;
        let across = ((wet[1] * warm_cos - wet[0] * warm_sin) * per_swing).abs();
        let wet_summer = along.gt(zero);
        let (up, down) = (rain + flat * wet_swing, rain - flat * wet_swing);
        let (up_edge, down_edge) = (rain + flat * across, rain - flat * across);
        let share = R::of(0.5) + along / (R::of(std::f32::consts::PI) * rain.max(R::of(1e-3)));
        Self {
            mean,
            warmest: mean + flat * swing,
            coldest: mean - flat * swing,
            fourth: mean + R::of(std::f32::consts::FRAC_1_SQRT_2) * flat * swing,
            rain,
            summer_share: share.clamp(zero, R::of(1.0)),
            summer_driest: monthly(wet_summer.pick(down_edge, down)),
            summer_wettest: monthly(wet_summer.pick(up, up_edge)),
            winter_driest: monthly(wet_summer.pick(down, down_edge)),
            winter_wettest: monthly(wet_summer.pick(up_edge, up)),
        }
    }
}

/// Rain of a month at a yearly rate, mm.
#[inline(always)]
fn monthly<R: Real>(rate: R) -> R {
    (rate * R::of(1.0 / 12.0)).positive()
}

/// The class of Koeppen and Geiger, 1 to 30.
#[inline(always)]
pub fn koeppen<R: Real>(m: &Months<R>) -> R {
    let of = R::of;
    let driest = m.summer_driest.min(m.winter_driest);

    let ten_pth = of(20.0) * m.mean;
    // Seven tenths in winter, in summer, or neither.
    let add = m.summer_share.lt(of(0.3)).pick(of(0.0), m.summer_share.gt(of(0.7)).pick(of(280.0), of(140.0)));
    let limit = (ten_pth + add).positive();
    let hot = m.mean.lt(of(18.0)).pick(of(1.0), of(0.0));
    let dry = m.rain.lt(of(0.5) * limit).pick(of(4.0), of(6.0)) + hot;

    let monsoon = driest.lt(of(100.0) - of(0.04) * m.rain).pick(of(3.0), of(2.0));
    let tropical = driest.lt(of(60.0)).pick(monsoon, of(1.0));

    // 0 dry summer, 1 dry winter, 2 neither.
    let no_dry_winter = m.winter_driest.lt(of(0.1) * m.summer_wettest).pick(of(1.0), of(2.0));
    let dry_summer = m.summer_driest.lt(m.winter_wettest * of(1.0 / 3.0)).pick(of(0.0), no_dry_winter);
    let dry_summer = m.summer_driest.lt(of(40.0)).pick(dry_summer, no_dry_winter);
    // Where both halves have a dry month, the drier one decides.
    let kind = m.summer_driest.lt(m.winter_driest).pick(dry_summer, no_dry_winter);
    // 0 hot summer, 1 warm, 2 cold, 3 very cold winter.
    let short = m.coldest.lt(of(-38.0)).pick(of(3.0), of(2.0));
    let cool = m.fourth.lt(of(10.0)).pick(short, of(1.0));
    let summer = m.warmest.lt(of(22.0)).pick(cool, of(0.0));
    let temperate = of(8.0) + of(3.0) * kind + summer.min(of(2.0));
    let cold = of(17.0) + of(4.0) * kind + summer;
    let polar = m.warmest.gt(of(0.0)).pick(of(29.0), of(30.0));

    let by_winter = m.coldest.gt(of(0.0)).pick(temperate, cold);
    let by_winter = m.coldest.lt(of(18.0)).pick(by_winter, tropical);
    let by_summer = m.warmest.gt(of(10.0)).pick(by_winter, polar);
    // Dryness goes before everything else, as in the tables of Peel and others.
    m.rain.lt(limit).pick(dry, by_summer)
}
