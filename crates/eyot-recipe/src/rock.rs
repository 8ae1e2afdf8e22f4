//! Rock in beds: materials of a recipe's own, and doubts about what the process `strata` is told in one step and not in another, and what needs it.

use crate::recipe::{ProcessUse, Recipe, Step, Work};
use eyot_core::layer::known;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The process that knows the beds.
pub(crate) const STRATA: &str = "strata";
/// Processes that act on rock alone.
const ON_ROCK: [&str; 3] = ["rockfall", "soak", "rock_cycle"];
/// Parameters that say where the beds lie, which counts when they are first laid.
const LAID: [&str; 6] = ["top", "dip", "dip_direction", "folds", "faults", "regolith"];

/// A material of which beds can be made: a new one, or a change of one that the process `strata` has. A step's own `strata.materials` has
/// the last word.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Material {
    /// Name by which beds call it, in legends, too.
    pub name: String,
    /// The material whose values it takes where it gives none: one of the process `strata`, or one that stands above it. A new one without it
    /// gives all but the colour.
    pub like: Option<String>,
    /// Steepest slope that a wall of it keeps: its talus angle.
    #[schemars(range(min = 1.0, max = 89.0), extend("unit" = "degree"))]
    pub talus: Option<f32>,
    /// How fast it wears, and how much of it standing water softens, over loose ground: its solubility.
    #[schemars(range(min = 0.0, max = 1000.0), extend("unit" = "1"))]
    pub erodibility: Option<f32>,
    /// Mass of a cubic metre, pores and their water included.
    #[schemars(range(min = 100.0, max = 10000.0), extend("unit" = "kg/m3"))]
    pub density: Option<f32>,
    /// Colour in sections, on maps and in legends, written `#rrggbb`; one by its number if not given.
    #[schemars(regex(pattern = r"^#[0-9a-fA-F]{6}$"))]
    pub colour: Option<String>,
}

/// What of the rock in a recipe was most likely not meant, a sentence each.
pub(crate) fn doubts(recipe: &Recipe) -> Vec<String> {
    let mut all = Vec::new();
    // Layers that are there, and the strata of the step before with what is in force there.
    let mut there: Vec<String> = Vec::new();
    let mut before: Option<(&Step, Value)> = None;
    for step in recipe.steps.iter().filter(|s| s.enabled) {
        let work = match &step.work {
            Work::Generate(g) => {
                there.push(g.layer.clone());
                continue;
            }
            Work::Simulate(work) => work,
        };
        let place = format!("step {} ({})", step.number, step.name);
        let acting: Vec<&ProcessUse> = work.processes.iter().filter(|u| u.enabled).collect();
        let writes = |u: &&ProcessUse| u.make().map(|p| p.writes()).unwrap_or_default();
        let others: Vec<_> = acting.iter().filter(|u| u.actor.name() != STRATA).flat_map(writes).collect();
        there.extend(others.into_iter().map(std::borrow::Cow::into_owned));
        let Some(strata) = acting.iter().find(|u| u.actor.name() == STRATA) else {
            for u in acting.iter().filter(|u| ON_ROCK.contains(&u.actor.name()) && before.is_none()) {
                // Rock that a generator made is as good.
                if !there.iter().any(|l| *l == known::ERODIBILITY.name || *l == known::ROCK_SLOPE.name) {
                    let name = u.actor.name();
                    all.push(format!(
                        "{place}: `{name}` finds no rock, which `{STRATA}` makes; simulate `{STRATA}` in the same step"
                    ));
                }
            }
            continue;
        };
        let now = strata.in_force();
        all.extend(surfaces(&now, &there).map(|d| format!("{place}: {d}")));
        if let Some(u) = acting.iter().find(|u| u.actor.name() == "streampower" && lifts(u)) {
            let rate = u.in_force()["uplift"].as_f64().map_or_else(String::new, |v| format!(" = {}", v as f32));
            all.push(format!(
                "{place}: streampower.uplift lifts the ground and leaves the beds where they are, so that what rises is loose; say \
                 streampower.uplift = 0.0 and {STRATA}.uplift{rate}, with {STRATA}.years_per_step"
            ));
        }
        if now["soaked"] != true && acting.iter().any(|u| u.actor.name() == "soak") {
            all.push(format!(
                "{place}: no bed accounts for what `soak` softens, and new rock keeps it: say {STRATA}.soaked = true"
            ));
        }
        if let Some((former, then)) = &before {
            let former = format!("step {} ({})", former.number, former.name);
            if then["new_rock"] == true && now["new_rock"] != true {
                all.push(format!(
                    "{place}: what hardened to new rock in {former} becomes a part of the beds, since {STRATA}.new_rock is off here; say \
                     {STRATA}.new_rock = true"
                ));
            }
            if ["beds", "materials", "repeat", "surfaces"].iter().any(|key| then[key] != now[key]) {
                all.push(format!(
                    "{place}: the beds are not those of {former}: the rock changes from one step to the next, and the ledger counts both \
                     by their numbers; give both steps the same beds and materials"
                ));
            }
            let moved: Vec<String> =
                LAID.iter().filter(|key| then[**key] != now[**key]).map(|key| format!("{STRATA}.{key}")).collect();
            if !moved.is_empty() {
                all.push(format!(
                    "{place}: the beds lie as {former} laid them; {} {} no effect here",
                    moved.join(", "),
                    if moved.len() == 1 { "has" } else { "have" }
                ));
            }
        }
        before = Some((step, now));
    }
    all
}

/// Surfaces of beds that nothing makes, and layers of surfaces that nothing reads.
fn surfaces(strata: &Value, there: &[String]) -> Option<String> {
    let bottoms = strata["beds"].as_array().map_or(0, |beds| beds.len().saturating_sub(1));
    let names: Vec<String> = (1..=4).map(|n| format!("bed_{n}")).collect();
    let (made, missing): (Vec<&String>, Vec<&String>) =
        names.iter().take(bottoms).partition(|name| there.contains(name));
    let list = |names: &[&String]| names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ");
    match strata["surfaces"].as_str()? {
        "flat" if !made.is_empty() => Some(format!(
            "nothing reads {}: say {STRATA}.surfaces = \"lower\" for depths below the bottoms of the beds, \"height\" for heights",
            list(&made)
        )),
        "lower" if made.is_empty() => Some(format!(
            "{STRATA}.surfaces reads {}, which no step before makes: all beds are as thick everywhere",
            list(&missing)
        )),
        "height" if !missing.is_empty() => Some(format!(
            "{STRATA}.surfaces reads {}, which no step before makes: the bottom of such a bed lies at 0 m",
            list(&missing)
        )),
        _ => None,
    }
}

/// True if a process raises the ground.
fn lifts(u: &ProcessUse) -> bool {
    u.in_force()["uplift"].as_f64() != Some(0.0) || u.terms.list().iter().any(|t| t.parameter() == "uplift")
}
