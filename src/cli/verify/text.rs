//! The text of the scene, in which the lines of spheres are found.

use std::{
    fs::{self, File},
    io::{self, BufReader, Read},
    path::Path,
};

use sfera::scene::{Scene, lines_of_spheres};

use crate::cli::{
    arguments::Job,
    failure::{Failure, STANDARD_INPUT, read_failed},
};

/// The text in which the line numbers of spheres are looked up.
#[derive(Debug)]
pub(super) enum SceneText<'job> {
    File(&'job Path),
    Bytes(Vec<u8>),
}

/// Reads the whole scene: a sphere that should not be visible in the rows may be the one that
/// the picture shows there.
pub(super) fn read_scene(job: &Job) -> Result<(Scene, SceneText<'_>), Failure> {
    let path = &*job.scene;
    let mut bytes = Vec::new();
    let name = if job.scene_is_standard_input() {
        io::stdin()
            .read_to_end(&mut bytes)
            .map_err(|error| read_failed(STANDARD_INPUT.as_ref(), error))?;
        STANDARD_INPUT.as_ref()
    } else if fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir()) {
        File::open(path)
            .and_then(|mut file| file.read_to_end(&mut bytes))
            .map_err(|error| read_failed(path, error))?;
        path
    } else {
        return Ok((Scene::read(path)?, SceneText::File(path)));
    };
    let scene = Scene::read_stream(&mut bytes.as_slice(), name, |_| |_: &_| true)?;
    Ok((scene, SceneText::Bytes(bytes)))
}

impl SceneText<'_> {
    /// The line numbers of some spheres, as far as they can be found.
    pub(super) fn lines(&self, spheres: &[usize]) -> Vec<Option<u64>> {
        let lines = match self {
            Self::File(path) => File::open(path)
                .and_then(|file| lines_of_spheres(&mut BufReader::new(file), spheres)),
            Self::Bytes(bytes) => lines_of_spheres(&mut bytes.as_slice(), spheres),
        };
        lines.unwrap_or_else(|_| vec![None; spheres.len()])
    }
}
