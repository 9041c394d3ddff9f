//! Reads the scene.

use std::io;

use sfera::{
    exact,
    render::Method,
    scene::{Scene, Viewport},
    spheres::Sphere,
};

use super::{
    arguments::Job,
    failure::{Failure, STANDARD_INPUT},
};

/// Reads the scene; for some rows, without the spheres that can't be visible in them.
pub(crate) fn read_scene(job: &Job) -> Result<Scene, Failure> {
    let exact = matches!(job.method(), Method::Exact | Method::Reference);
    if job.rows.is_some() && exact {
        let (size, rows) = (job.size(), job.rows());
        read_kept(job, |viewport| exact::may_show(viewport, size, rows))
    } else if job.scene_is_standard_input() {
        read_kept(job, |_| |_: &_| true)
    } else {
        Ok(Scene::read(&job.scene)?)
    }
}

fn read_kept<K>(job: &Job, filter: impl FnOnce(Viewport) -> K) -> Result<Scene, Failure>
where
    K: Fn(&Sphere) -> bool + Sync,
{
    Ok(if job.scene_is_standard_input() {
        Scene::read_stream(&mut io::stdin(), STANDARD_INPUT, filter)
    } else {
        Scene::read_kept(&job.scene, filter)
    }?)
}
