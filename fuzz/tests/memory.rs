//! Numbers that files claim, field by field and behind checksums that fit: refused, or harmless, and in bounded memory.

use eyot_testing::counting::{Counting, held};

#[global_allocator]
static COUNTING: Counting = Counting;

/// What worlds of so few cells and colonies may take however they lie: the limit of all targets is eight times as much.
const MOST: usize = 8 << 20;
/// The same with pictures and files, which have sizes of their own.
const MOST_WITH_FILES: usize = 64 << 20;

fn bounded<T>(most: usize, input: &[u8], work: impl FnOnce() -> T) -> T {
    let (bytes, result) = held(work);
    assert!(bytes < most, "{input:?} took {bytes} bytes");
    result
}

/// All in one test: what others do at the same time would be counted, too.
#[test]
fn checkpoints_are_sound_field_by_field() {
    let component = eyot_fuzz::target("component").unwrap();
    let (mut inputs, mut refused) = (0, 0);
    eyot_fuzz::component_by_component(|input| {
        inputs += 1;
        refused += usize::from(!bounded(MOST, input, || (component.run)(input)));
    });
    assert!(inputs > 1000 && refused > inputs / 4 && refused < inputs, "{refused} of {inputs} components");

    let state = eyot_fuzz::target("state").unwrap();
    assert!(eyot_fuzz::loaded(&[0]).is_some() && eyot_fuzz::finished(&[0]));
    let (mut inputs, mut accepted) = (0, 0);
    eyot_fuzz::field_by_field(160, |input| {
        inputs += 1;
        if bounded(MOST, input, || eyot_fuzz::loaded(input).is_some()) {
            accepted += 1;
            // Going on takes some milliseconds, pictures some more.
            if accepted % 101 == 1 {
                bounded(MOST_WITH_FILES, input, || (state.run)(input));
            }
            if accepted % 307 == 1 {
                bounded(MOST_WITH_FILES, input, || eyot_fuzz::finished(input));
            }
        }
    });
    assert!(inputs > 500 && accepted > 50 && accepted < inputs, "{accepted} of {inputs}");
    // A disturbance a billion months ago would be made up for a billion times.
    let date = [&[0, 0, 16, 0, 7][..], &(-1e9f64).to_le_bytes()].concat();
    assert!(eyot_fuzz::loaded(&date).is_none());
}
