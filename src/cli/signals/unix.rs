//! Unix: signals that clean up, limits that are errors, pages that are lost.

use std::{
    ffi::CString,
    os::unix::ffi::OsStrExt,
    path::Path,
    sync::{
        Once, OnceLock,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
    time::Duration,
};

use libc::{
    SIGABRT, SIGALRM, SIGBUS, SIGFPE, SIGHUP, SIGILL, SIGINT, SIGPROF, SIGQUIT, SIGSYS, SIGTERM,
    SIGTRAP, SIGUSR1, SIGUSR2, SIGVTALRM, SIGXCPU, SIGXFSZ,
};
use sfera::{name::shown, ppm::Event};

use crate::cli::tell;

/// Signals that end a program which does nothing about them. `SIGSEGV` is left to
/// the standard library, which tells of a stack that is too small.
const ENDINGS: [i32; 16] = [
    SIGHUP, SIGINT, SIGQUIT, SIGILL, SIGTRAP, SIGABRT, SIGBUS, SIGFPE, SIGUSR1, SIGUSR2, SIGALRM,
    SIGTERM, SIGXCPU, SIGVTALRM, SIGPROF, SIGSYS,
];

/// Such signals of Linux alone, of which nobody thinks as long as there is nothing to
/// remove.
#[cfg(target_os = "linux")]
fn more_endings() -> impl Iterator<Item = i32> {
    [libc::SIGSTKFLT, libc::SIGIO, libc::SIGPWR]
        .into_iter()
        .chain(libc::SIGRTMIN()..=libc::SIGRTMAX())
}

#[cfg(not(target_os = "linux"))]
fn more_endings() -> impl Iterator<Item = i32> {
    std::iter::empty()
}

/// The exit code that a shell gives to a program ended by a signal.
fn exit_code(signal: i32) -> i32 {
    128 + signal
}

/// Names to remove; more than one run has.
static TEMPORARIES: [OnceLock<CString>; 16] = [const { OnceLock::new() }; 16];

/// What to say when the pages of an image are lost, an image each.
static LOST: [OnceLock<String>; 2] = [const { OnceLock::new() }; 2];

/// Which of them is being drawn.
static DRAWN: AtomicUsize = AtomicUsize::new(0);

/// An image is about to have its name: an interrupt comes too late.
static HELD: AtomicBool = AtomicBool::new(false);

/// A progress bar is on the terminal.
static BAR: AtomicBool = AtomicBool::new(false);

/// Some thread is ending the program.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Makes signals exit codes and messages. Those that whoever started the program
/// wants ignored (`nohup`, a shell's background job) stay ignored.
pub(crate) fn prepare() {
    ENDINGS.into_iter().for_each(handle_end);
    // A file past the limit on file sizes: the signal does nothing, the call fails.
    handle(SIGXFSZ, libc::SIG_IGN);
}

fn handle_end(signal: i32) {
    handle(signal, end as extern "C" fn(i32) as libc::sighandler_t);
}

/// Sets what a signal does, in place of all that was to be done before; nothing
/// where the system has another use for it.
#[expect(
    unsafe_code,
    reason = "the standard library has no handlers of signals"
)]
fn handle(signal: i32, handler: libc::sighandler_t) {
    // SAFETY: both structures are plain data, for which zeros are valid, and live
    // through the calls. `handler` is SIG_IGN or `end`, which takes no lock,
    // allocates nothing, and makes only system calls on memory that was made
    // before; all signals wait while it runs.
    unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        let asked = libc::sigaction(signal, std::ptr::null(), &raw mut action);
        if asked != 0 || action.sa_sigaction == libc::SIG_IGN {
            return;
        }
        action = std::mem::zeroed();
        action.sa_sigaction = handler;
        action.sa_flags = libc::SA_RESTART;
        libc::sigfillset(&raw mut action.sa_mask);
        libc::sigaction(signal, &raw const action, std::ptr::null_mut());
    }
}

/// Ends the program by a signal, once its temporary files are removed.
extern "C" fn end(signal: i32) {
    let (message, code) = match signal {
        SIGBUS => {
            let lost = LOST.get(DRAWN.load(Ordering::SeqCst));
            (lost.and_then(OnceLock::get).map_or("", String::as_str), 1)
        }
        // Whoever aborts has told why.
        SIGABRT => ("", 1),
        _ if HELD.load(Ordering::SeqCst) => return,
        SIGXCPU => (
            "sfera: the limit on processor time is used up; raise it (ulimit -t)\n",
            1,
        ),
        _ => ("", exit_code(signal)),
    };
    end_with(message.as_bytes(), code)
}

/// Ends the program with a message and an exit code, from anywhere: a handler of
/// a signal, or where there is no memory.
#[expect(
    unsafe_code,
    reason = "the standard library's exit runs code of others"
)]
pub(crate) fn end_with(message: &[u8], code: i32) -> ! {
    while ENDING.swap(true, Ordering::SeqCst) {
        // Another thread is at it, and ends this one with it.
        std::thread::sleep(Duration::from_secs(1));
    }
    for name in TEMPORARIES.iter().filter_map(OnceLock::get) {
        let _ = rustix::fs::unlink(name.as_c_str());
    }
    if BAR.load(Ordering::SeqCst) {
        let _ = rustix::io::write(rustix::stdio::stderr(), b"\r\x1b[K");
    }
    if !message.is_empty() {
        let _ = rustix::io::write(rustix::stdio::stderr(), message);
    }
    // SAFETY: it takes a number and does not return.
    unsafe { libc::_exit(code) }
}

/// Notes what has to be removed, and tells what is waited for.
pub(crate) fn watch(event: Event<'_>) {
    match event {
        Event::Temporary(path) => note(path),
        Event::Waiting(folder) => tell(format_args!(
            "sfera: {}: another process has locked this directory, perhaps to make the same image; waiting for it for 10 seconds at most",
            shown(folder)
        )),
        _ => {}
    }
}

/// As `watch`, in silence.
pub(crate) fn watch_quietly(event: Event<'_>) {
    if let Event::Temporary(path) = event {
        note(path);
    }
}

fn note(temporary: &Path) {
    static FIRST: Once = Once::new();
    FIRST.call_once(|| {
        more_endings().for_each(handle_end);
        leave_time_to_clean_up();
    });
    if let Ok(name) = CString::new(temporary.as_os_str().as_bytes()) {
        let free = TEMPORARIES.iter().find(|slot| slot.get().is_none());
        if let Some(slot) = free {
            let _ = slot.set(name);
        }
    }
}

/// Where the limit on processor time is one that kills, asks for the signal that
/// can be acted on a second before.
fn leave_time_to_clean_up() {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let limit = getrlimit(Resource::Cpu);
    if let (Some(current), Some(maximum)) = (limit.current, limit.maximum)
        && current >= maximum
        && maximum > 1
    {
        let _ = setrlimit(
            Resource::Cpu,
            Rlimit {
                current: Some(maximum - 1),
                maximum: Some(maximum),
            },
        );
    }
}

/// From now on it is this image that is lost with a page: the first or the second.
pub(crate) fn draws(index: usize, path: &Path) {
    if let Some(lost) = LOST.get(index) {
        lost.get_or_init(|| {
            format!(
                "sfera: {}: the file was shortened or its disk failed while it was drawn; draw it again\n",
                shown(path)
            )
        });
    }
    DRAWN.store(index, Ordering::SeqCst);
}

/// From now on an interrupt comes too late: an image is about to have its name.
pub(crate) fn hold() {
    HELD.store(true, Ordering::SeqCst);
}

/// Whether a progress bar is to be removed from the terminal.
pub(crate) fn bar(shown: bool) {
    BAR.store(shown, Ordering::SeqCst);
}
