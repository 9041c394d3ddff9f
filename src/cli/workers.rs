//! The threads that draw: this one, and more if the work takes long enough.

use std::{
    fs,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use super::{arguments::Job, system};

/// A pool that this thread belongs to. The other threads are started only if the work takes
/// long: starting one for each of many CPUs would take longer than drawing an easy picture
/// of 1920 x 1080 on one thread, a millisecond.
#[derive(Debug)]
pub(crate) struct Workers {
    pool: ThreadPool,
    start: Instant,
    waiting: Mutex<Vec<ThreadBuilder>>,
    /// The number given on the command line.
    threads: Option<usize>,
    /// Which threads have drawn something.
    drew: Vec<AtomicBool>,
}

/// Work that has taken this long is worth more threads.
const PATIENCE: Duration = Duration::from_millis(2);

/// More pixels than this take longer than that, if only to fault in their pages.
const MANY_PIXELS: u64 = 4 << 20;

/// More bytes of a scene than this take longer than that to read and prepare.
const LONG_SCENE: u64 = 256 << 10;

impl Workers {
    pub(crate) fn new(threads: Option<usize>) -> Result<Self, ThreadPoolBuildError> {
        let mut waiting = Vec::new();
        let pool = ThreadPoolBuilder::new()
            .num_threads(threads.unwrap_or_else(system::processors))
            .use_current_thread()
            .spawn_handler(|worker| {
                waiting.push(worker);
                Ok(())
            })
            .build()?;
        let drew = (0..pool.current_num_threads())
            .map(|_| AtomicBool::new(false))
            .collect();
        Ok(Self {
            pool,
            drew,
            start: Instant::now(),
            waiting: Mutex::new(waiting),
            threads,
        })
    }

    /// Runs `job` in the pool, with all its threads from the beginning if there is much to do.
    pub(crate) fn run<R: Send>(&self, job: &Job, run: impl FnOnce() -> R + Send) -> R {
        let long_scene = !fs::metadata(&job.scene)
            .is_ok_and(|scene| scene.is_file() && scene.len() <= LONG_SCENE);
        if job.is_laborious() || job.pixels() > MANY_PIXELS || long_scene {
            self.start_others();
        }
        self.pool.install(run)
    }

    /// Records that the calling thread has drawn something.
    pub(crate) fn has_drawn(&self) {
        let drew = rayon::current_thread_index().and_then(|index| self.drew.get(index));
        if let Some(drew) = drew {
            drew.store(true, Ordering::Relaxed);
        }
    }

    /// How many threads have drawn something.
    pub(crate) fn that_drew(&self) -> usize {
        let drew = self.drew.iter();
        drew.filter(|drew| drew.load(Ordering::Relaxed)).count()
    }

    /// Starts the other threads if the work has taken long enough.
    pub(crate) fn start_others_if_late(&self) {
        if self.start.elapsed() > PATIENCE {
            self.start_others();
        }
    }

    /// Starts the other threads, as many as may run. If the system refuses some, the others
    /// do their share of the work.
    fn start_others(&self) {
        let waiting = {
            let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
            std::mem::take(&mut *waiting)
        };
        if waiting.is_empty() {
            return;
        }
        // Determined only now, because it takes reading several files.
        let limit = self
            .threads
            .unwrap_or_else(|| thread::available_parallelism().map_or(usize::MAX, usize::from));
        for worker in waiting.into_iter().take(limit - 1) {
            if thread::Builder::new().spawn(|| worker.run()).is_err() {
                return;
            }
        }
    }
}
