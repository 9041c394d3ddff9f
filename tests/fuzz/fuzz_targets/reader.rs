//! Reads any bytes as a scene.
//!
//! - Nothing panics, and a message is short, printable, and about a place in the text.
//! - A scene, written as text and read again, is the same scene.
//! - Windows and chunks of any size give the same as the word-by-word parser:
//!   the same scene, or the same message.

#![no_main]

use libfuzzer_sys::fuzz_target;
use sfera::{
    scene::{Scene, SceneError},
    testing::{Sizes, parse_in_windows},
};

/// The greatest length of a message: an excerpt and two quotations, every byte an escape.
const LONGEST_MESSAGE: usize = 2000;

fuzz_target!(
    init: {
        // On this thread only, so that results are reproducible.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
        pool.use_current_thread().build_global().expect("a thread pool");
    },
    |text: &[u8]| {
        let parsed = Scene::parse(text);
        match &parsed {
            Ok(scene) => {
                let again = Scene::parse(scene.to_string().as_bytes()).expect("its own text");
                assert_eq!(bits(scene), bits(&again));
            }
            Err(error) => check_message(text, error),
        }
        let found = outcome(&parsed);
        let word_by_word = Sizes { fast: usize::MAX, ..Sizes::USUAL };
        assert_eq!(found, outcome(&parse_in_windows(text, word_by_word)));
        let sizes = sizes(text);
        assert_eq!(found, outcome(&parse_in_windows(text, sizes)), "{sizes:?}");
    }
);

/// Sizes computed from the text, so that the text alone reproduces a case.
fn sizes(text: &[u8]) -> Sizes {
    let mut state = text.iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3)
    });
    let mut up_to = |most: usize| {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(1);
        1 + (state >> 33) as usize % most
    };
    let most = text.len() + 2;
    Sizes {
        first: up_to(most),
        window: up_to(most),
        chunk: up_to(most),
        parallel: up_to(most),
        fast: up_to(256),
    }
}

fn check_message(text: &[u8], error: &SceneError) {
    let message = error.to_string();
    assert!(message.len() <= LONGEST_MESSAGE, "{} bytes", message.len());
    let odd = |character: char| character.is_control() && character != '\n';
    assert!(!message.contains(odd), "{message:?}");
    let lines = text.iter().filter(|&&byte| byte == b'\n').count() as u64 + 1;
    let (line, column) = (
        error.line().expect("a line"),
        error.column().expect("a column"),
    );
    assert!((1..=lines).contains(&line), "line {line} of {lines}");
    assert!(
        (1..=text.len() as u64 + 1).contains(&column),
        "column {column}"
    );
}

/// The scene as bits, or the message.
fn outcome(parsed: &Result<Scene, SceneError>) -> Result<Vec<u32>, String> {
    match parsed {
        Ok(scene) => Ok(bits(scene)),
        Err(error) => Err(format!("{:?} {error}", error.kind())),
    }
}

fn bits(scene: &Scene) -> Vec<u32> {
    let colour = |[red, green, blue]: [u8; 3]| u32::from_be_bytes([0, red, green, blue]);
    let viewport = scene.viewport();
    let mut bits: Vec<u32> = [viewport.width(), viewport.height(), viewport.distance()]
        .map(f32::to_bits)
        .into();
    bits.push(colour(scene.background()));
    for sphere in scene.spheres().iter() {
        bits.extend(sphere.centre().map(f32::to_bits));
        bits.extend([sphere.radius().to_bits(), colour(sphere.colour())]);
    }
    // With the padding: every lane that a packet may load.
    let padded = [scene.spheres().x(), scene.spheres().radius()];
    bits.extend(padded.concat().into_iter().map(f32::to_bits));
    bits
}
