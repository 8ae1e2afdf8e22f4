//! Parts of a grid: what their steps may look at, and what becomes of what acts there.

use eyot_core::conformance;
use eyot_core::engine::CpuEngine;
use eyot_core::plan::Plan;
use eyot_core::process::{Action, ActionInstance, LayerUse, Locality, Moment, Process, Scheduled, Span};
use eyot_core::real::Real;
use eyot_core::rule::{Cell, Read, Rule, read};
use eyot_core::stepper::reach;
use eyot_core::{Boundary, Control, Domain, Error, Field, Grid, LayerSpec, Limits, Result, World, rule_params};

const LEVEL: LayerSpec = LayerSpec::new("level", "m", "", (-1e9, 1e9));
const TRACE: LayerSpec = LayerSpec::new("trace", "1", "", (-1e9, 1e9));

rule_params! {
    /// Parameters of [`Mix`] and [`Shift`].
    pub struct MixParams {
        /// Weight of what is around.
        weight,
    }
}

/// Mixes a cell with those around it, its place and a random number.
struct Mix;

impl Rule for Mix {
    const NAME: &'static str = "mix";
    const READS: &'static [Read] = &[read("level", 2)];
    const WRITES: &'static [&'static str] = &["level"];
    type Params = MixParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    fn cell<R: Real>(p: &MixParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        let around = c.at(0, 2, -1) + c.at(0, -2, 0) + c.at(0, 1, 2) + c.at(0, 0, -2);
        ([p.weight * around + c.x() - R::of(0.5) * c.y() + c.uniform(3)], [])
    }
}

/// Takes the level next to a cell.
struct Shift;

impl Rule for Shift {
    const NAME: &'static str = "shift";
    const READS: &'static [Read] = &[read("level", 1)];
    const WRITES: &'static [&'static str] = &["trace"];
    type Params = MixParams<()>;
    type Out<R: Real> = [R; 1];
    type Sums<R: Real> = [R; 0];

    fn cell<R: Real>(p: &MixParams<R>, c: &impl Cell<R>) -> ([R; 1], [R; 0]) {
        ([p.weight * c.at(0, 1, 0)], [])
    }
}

/// Both rules, and what lifts the level.
struct Both {
    lift: Option<Lift>,
}

impl Process for Both {
    fn layers(&self) -> Vec<LayerUse> {
        vec![LEVEL.changed(1.0), TRACE.written(0.0)]
    }

    fn plan(&self, _: &Moment, plan: &mut Plan) {
        plan.push::<Mix>(MixParams { weight: 0.25 });
        plan.push::<Shift>(MixParams { weight: 1.0 });
    }

    fn action(&self) -> Option<&dyn Action> {
        self.lift.as_ref().map(|l| l as &dyn Action)
    }
}

/// Adds a number to all cells, which says that it looks so far.
#[derive(Clone)]
struct Lift(Locality);

impl Action for Lift {
    fn instantiate(&self, _world: &World) -> Result<Box<dyn ActionInstance>> {
        Ok(Box::new(self.clone()))
    }

    fn locality(&self) -> Locality {
        self.0
    }

    fn bytes_per_cell(&self) -> usize {
        0
    }
}

impl ActionInstance for Lift {
    fn act(&mut self, moment: &Moment, world: &mut World, _: &Control<'_>) -> Result<()> {
        let cells = moment.domain.inside_columns().len() * moment.domain.inside_rows().len();
        world.ledger.add("level.lifted", cells as f64, "1", "", 1);
        world.layer_mut("level")?.field.map_in_place(|v| v + 0.5);
        Ok(())
    }
}

fn both(lift: Option<Locality>) -> Vec<Scheduled> {
    vec![Scheduled { name: "both", process: Box::new(Both { lift: lift.map(Lift) }), every: 1 }]
}

fn world() -> World {
    let grid = Grid::new(40, 20, 1.0, Boundary::WRAP, &Limits::default()).unwrap();
    let mut world = World::new(grid, 5);
    world.put(&LEVEL, Field::from_fn(40, 20, |x, y| ((x * 7 + y * 3) % 11) as f32)).unwrap();
    world.ensure(&TRACE, 0.0);
    world
}

fn steps(world: &mut World, processes: &[Scheduled], steps: u64) -> Result<()> {
    CpuEngine::default().simulate(world, processes, Span { from: 0, steps }, &Control::none())
}

#[test]
fn rules_and_actions_of_cells_conform_in_windows() {
    for lift in [None, Some(Locality::Cell), Some(Locality::Rows(2))] {
        assert!(conformance::check_windows(&both(lift), &|_, u| u).unwrap());
    }
    assert!(!conformance::check_windows(&both(Some(Locality::Whole)), &|_, u| u).unwrap());
}

#[test]
fn reaches_add_up_along_what_depends() {
    let far = |lift, steps| reach(&both(lift), Moment::of(&world()), Span { from: 0, steps });
    // Two for the level, one more for its copy; a step later two more.
    assert_eq!(far(None, 1), Locality::Rows(3));
    assert_eq!(far(None, 3), Locality::Rows(7));
    assert_eq!(far(Some(Locality::Cell), 1), Locality::Rows(3));
    assert_eq!(far(Some(Locality::Rows(4)), 1), Locality::Rows(7));
    assert_eq!(far(Some(Locality::Whole), 1), Locality::Whole);
}

#[test]
fn several_steps_need_no_new_halo_as_long_as_it_lasts() {
    let mut whole = world();
    steps(&mut whole, &both(Some(Locality::Cell)), 2).unwrap();
    let mut joined = world();
    let mut lifted = 0.0;
    for columns in [0..13, 13..40] {
        let domain = Domain::window(world().grid, columns, 0..20, 6).unwrap();
        let mut part = world().cut(domain).unwrap();
        steps(&mut part, &both(Some(Locality::Cell)), 2).unwrap();
        lifted += part.ledger.amount("level.lifted");
        joined.paste(&part).unwrap();
    }
    assert_eq!(lifted, whole.ledger.amount("level.lifted"));
    assert_eq!(joined.layers(), whole.layers());
}

#[test]
fn what_a_window_cannot_do_is_refused_before_the_first_step() {
    let domain = Domain::window(world().grid, 3..9, 2..20, 5).unwrap();
    let part = world().cut(domain).unwrap();
    for (lift, count) in [(None, 3), (Some(Locality::Rows(4)), 1), (Some(Locality::Whole), 1)] {
        let mut tried = part.clone();
        let refused = steps(&mut tried, &both(lift), count).unwrap_err();
        assert!(matches!(refused, Error::Window(_)), "{refused}");
        assert_eq!(tried, part);
    }
    steps(&mut part.clone(), &both(None), 2).unwrap();
    assert!(part.cut(domain).is_err(), "a window is no whole");
    assert!(World::new(part.grid, 5).cut(domain).is_err(), "another grid");
    let mut bent = part.clone();
    bent.grid.width += 1;
    assert!(matches!(steps(&mut bent, &both(None), 1), Err(Error::Window(_))));
}
