//! Unix: interrupts that clean up, limits that are errors, pages that are lost.

use std::{
    ffi::CString,
    fs, io,
    os::unix::ffi::OsStrExt,
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex, OnceLock,
        atomic::{AtomicBool, Ordering},
    },
    thread,
};

use signal_hook::{
    consts::{SIGABRT, SIGHUP, SIGINT, SIGTERM, SIGXFSZ},
    flag,
    iterator::Signals,
};

/// The signals by which users and batch systems end a program.
const ENDINGS: [i32; 3] = [SIGINT, SIGTERM, SIGHUP];

/// The exit code that a shell gives to a program ended by a signal.
fn exit_code(signal: i32) -> i32 {
    128 + signal
}

/// Interrupts end the program at once, as long as nothing has to be cleaned up.
#[derive(Debug)]
pub(crate) struct Interrupts {
    at_once: Arc<AtomicBool>,
    honoured: Vec<i32>,
    /// Files to remove first, once there are any.
    temporaries: OnceLock<Arc<Mutex<Vec<PathBuf>>>>,
}

/// Makes interrupts exit codes and the other signals errors that can be told.
pub(crate) fn prepare() -> io::Result<Interrupts> {
    let at_once = Arc::new(AtomicBool::new(true));
    let ignored = ignored();
    let honoured: Vec<i32> = ENDINGS
        .into_iter()
        .filter(|signal| ignored >> (signal - 1) & 1 == 0)
        .collect();
    for &signal in &honoured {
        flag::register_conditional_shutdown(signal, exit_code(signal), Arc::clone(&at_once))?;
    }
    // A file past the limit on file sizes: the signal does nothing, the call fails.
    flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))?;
    // Memory that can't be had: the standard library has told so by then.
    flag::register_conditional_shutdown(SIGABRT, 1, Arc::new(AtomicBool::new(true)))?;
    Ok(Interrupts {
        at_once,
        honoured,
        temporaries: OnceLock::new(),
    })
}

impl Interrupts {
    /// From now on an interrupt removes `temporary` before it ends the program.
    pub(crate) fn remove(&self, temporary: &Path) -> io::Result<()> {
        let temporaries = self.temporaries.get_or_init(Arc::default);
        if let Ok(mut temporaries) = temporaries.lock() {
            temporaries.push(temporary.to_owned());
        }
        if !self.at_once.load(Ordering::SeqCst) {
            return Ok(());
        }
        let mut signals = Signals::new(&self.honoured)?;
        self.hold();
        let temporaries = Arc::clone(temporaries);
        thread::Builder::new().spawn(move || {
            if let Some(signal) = signals.forever().next() {
                if let Ok(temporaries) = temporaries.lock() {
                    for temporary in temporaries.iter() {
                        let _ = fs::remove_file(temporary);
                    }
                }
                signal_hook::low_level::exit(exit_code(signal));
            }
        })?;
        Ok(())
    }

    /// From now on an interrupt comes too late: the image is about to have its name.
    pub(crate) fn hold(&self) {
        self.at_once.store(false, Ordering::SeqCst);
    }
}

/// Ends the process with `message` and exit code 1 if a mapped image is taken
/// away under it: shortened by another process, or its disk gone. `temporary`
/// is removed first.
#[expect(
    unsafe_code,
    reason = "a signal is how the system tells of a lost page"
)]
pub(crate) fn exit_when_lost(message: String, temporary: Option<&Path>) -> io::Result<()> {
    let temporary = temporary.and_then(|path| CString::new(path.as_os_str().as_bytes()).ok());
    let action = move || {
        if let Some(name) = &temporary {
            let _ = rustix::fs::unlink(name.as_c_str());
        }
        let _ = rustix::io::write(rustix::stdio::stderr(), message.as_bytes());
        signal_hook::low_level::exit(1);
    };
    // SAFETY: the action does three system calls on memory made beforehand;
    // it takes no lock and allocates nothing.
    unsafe { signal_hook::low_level::register(signal_hook::consts::SIGBUS, action) }?;
    Ok(())
}

/// The signals that whoever started the program wants ignored (`nohup`, a shell's
/// background job), a bit each. Linux tells them; elsewhere they are taken for none.
fn ignored() -> u64 {
    fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|status| {
            let mask = status
                .lines()
                .find_map(|line| line.strip_prefix("SigIgn:"))?;
            u64::from_str_radix(mask.trim(), 16).ok()
        })
        .unwrap_or(0)
}
