//! What doubles and double-doubles decide, against integers.

use super::{Candidate, Rung, Seen, decide};
use crate::exact::trials::{Random, each_trial, sphere};

/// Spheres that are hard to tell from the trial's, and others.
fn rival(lengths: [f32; 4], random: &mut Random) -> [f32; 4] {
    let mut rival = lengths;
    match random.below(4) {
        0 => {}
        1 => {
            let length = &mut rival[random.below(4) as usize];
            *length = if random.below(2) == 0 {
                length.next_up()
            } else {
                length.next_down()
            };
        }
        2 => {
            // The same outline, nearer or farther by a power of two.
            let factor = [0.5, 2.0, 1.0][random.below(3) as usize];
            rival = rival.map(|length| length * factor);
        }
        _ => {
            for length in &mut rival {
                *length *= random.between(0.999_999, 1.000_001) as f32;
            }
        }
    }
    let usable = rival.iter().all(|length| length.is_finite()) && rival[3] > 0.0;
    if usable { rival } else { lengths }
}

#[test]
fn every_rung_sees_the_sphere_that_integers_see() {
    let mut rungs = [0; 3];
    each_trial(60_000, |trial, random| {
        let count = 1 + random.below(11) as u32;
        let mut candidates: Vec<Candidate> = (0..count)
            .map(|index| {
                let lengths = if random.below(5) == 0 {
                    let other = sphere(random, &trial.camera, trial.column, trial.row);
                    let [x, y, z] = other.centre;
                    [x, y, z, other.radius]
                } else {
                    rival(trial.lengths(), random)
                };
                (index as Seen, lengths)
            })
            .collect();
        let at = random.below(u64::from(count)) as usize;
        candidates[at].1 = trial.lengths();
        candidates.rotate_left(random.below(u64::from(count)) as usize);
        let pixel = (trial.column, trial.row);
        let (exact, _) = decide(&trial.camera, pixel, &mut candidates.clone(), false);
        let (seen, rung) = decide(&trial.camera, pixel, &mut candidates.clone(), true);
        rungs[match rung {
            Rung::Doubles => 0,
            Rung::DoubleDoubles => 1,
            Rung::Integers => 2,
        }] += 1;
        if seen == exact {
            Ok(())
        } else {
            Err(format!(
                "{seen} by {rung:?} instead of {exact} of {candidates:?}"
            ))
        }
    });
    assert!(rungs.iter().all(|&count| count > 100), "only {rungs:?}");
}
