//! The threads that draw: this one and as many more as asked for.

use std::{io, thread};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// A pool that this thread is part of. Threads that the system refuses are done
/// without: the others draw their share.
pub(crate) fn pool(threads: Option<usize>) -> Result<ThreadPool, ThreadPoolBuildError> {
    let threads = threads.unwrap_or_else(|| thread::available_parallelism().map_or(1, usize::from));
    ThreadPoolBuilder::new()
        .num_threads(threads)
        .use_current_thread()
        .spawn_handler(|worker| {
            let _: io::Result<_> = thread::Builder::new().spawn(|| worker.run());
            Ok(())
        })
        .build()
}
