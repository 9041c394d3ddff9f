//! Unix: signals that end the program, limits that raise signals, lost pages of a mapped file.

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

use crate::cli::messages::tell;

/// Signals that end a program by default. `SIGSEGV` is left to the standard library, which
/// reports a stack overflow.
const ENDINGS: [i32; 16] = [
    SIGHUP, SIGINT, SIGQUIT, SIGILL, SIGTRAP, SIGABRT, SIGBUS, SIGFPE, SIGUSR1, SIGUSR2, SIGALRM,
    SIGTERM, SIGXCPU, SIGVTALRM, SIGPROF, SIGSYS,
];

/// More of them, only on Linux. They are rare, so they are handled only while there is a
/// file to remove.
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

/// Names to remove; there is room for more than one run can have.
static TEMPORARIES: [OnceLock<CString>; 16] = [const { OnceLock::new() }; 16];

/// The message for each image when its pages are lost.
static LOST: [OnceLock<String>; 2] = [const { OnceLock::new() }; 2];

/// The number of the image that is being drawn.
static DRAWN: AtomicUsize = AtomicUsize::new(0);

/// Whether an image is about to get its name, so that an interrupt comes too late.
static HELD: AtomicBool = AtomicBool::new(false);

/// Whether a progress bar is on the terminal.
static BAR: AtomicBool = AtomicBool::new(false);

/// Whether a thread is ending the program.
static ENDING: AtomicBool = AtomicBool::new(false);

/// Installs the handlers, which turn signals into exit codes and messages. Signals that the
/// parent process ignores (`nohup`, a shell's background job) stay ignored.
pub(crate) fn prepare() {
    ENDINGS.into_iter().for_each(handle_end);
    // For a file beyond the limit on file sizes, the signal is ignored and the call fails.
    handle(SIGXFSZ, libc::SIG_IGN);
}

fn handle_end(signal: i32) {
    handle(signal, end as extern "C" fn(i32) as libc::sighandler_t);
}

/// Replaces the handler of a signal. Does nothing if the signal is ignored, or if the system
/// uses it itself.
#[expect(unsafe_code, reason = "the standard library has no signal handlers")]
fn handle(signal: i32, handler: libc::sighandler_t) {
    // SAFETY: both structures are plain data, for which zeros are valid, and they live
    // through the calls. `handler` is SIG_IGN or `end`, which takes no lock, allocates
    // nothing, and makes only system calls on memory that was allocated before. All signals
    // are blocked while it runs.
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

/// The handler: removes temporary files and ends the program.
extern "C" fn end(signal: i32) {
    let (message, code) = match signal {
        SIGBUS => {
            let lost = LOST.get(DRAWN.load(Ordering::SeqCst));
            (lost.and_then(OnceLock::get).map_or("", String::as_str), 1)
        }
        // Code that aborts has printed a message.
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

/// Ends the program with a message and an exit code. It may be called anywhere: in a signal
/// handler, or when an allocation failed.
#[expect(
    unsafe_code,
    reason = "the standard library's exit runs other code at exit"
)]
pub(crate) fn end_with(message: &[u8], code: i32) -> ! {
    while ENDING.swap(true, Ordering::SeqCst) {
        // Another thread is ending the program, and this one with it.
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
    // SAFETY: `_exit` takes a number and does not return.
    unsafe { libc::_exit(code) }
}

/// Records the names to remove, and reports what the program waits for.
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

/// Like `watch`, without messages.
pub(crate) fn watch_quietly(event: Event<'_>) {
    if let Event::Temporary(path) = event {
        note(path);
    }
}

fn note(temporary: &Path) {
    static FIRST: Once = Once::new();
    FIRST.call_once(|| {
        more_endings().for_each(handle_end);
        warn_before_time_is_up();
    });
    if let Ok(name) = CString::new(temporary.as_os_str().as_bytes()) {
        let free = TEMPORARIES.iter().find(|slot| slot.get().is_none());
        if let Some(slot) = free {
            let _ = slot.set(name);
        }
    }
}

/// If the limit on processor time would kill the program, lowers its soft limit by a second,
/// so that a signal that can be handled comes first.
fn warn_before_time_is_up() {
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

/// Sets the image, the first or the second, that a lost page belongs to from now on.
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

/// From now on interrupts are ignored: an image is about to get its name.
pub(crate) fn hold() {
    HELD.store(true, Ordering::SeqCst);
}

/// Records whether a progress bar must be removed from the terminal.
pub(crate) fn bar(shown: bool) {
    BAR.store(shown, Ordering::SeqCst);
}
