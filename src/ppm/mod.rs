//! The image file, a binary PPM: reserve blocks, map them, publish the file.
//!
//! ```text
//! P6\nWIDTH HEIGHT\n255\n      then 3 bytes a pixel, rows from the top
//! ```
//!
//! There are three ways to make an image. Each hands groups of whole rows to a
//! closure that draws them:
//!
//! | | draws into | the image appears |
//! | --- | --- | --- |
//! | [`MappedImage`] | a mapped file without a name | under its name, whole, in one step |
//! | [`SharedImage`] | the file itself, some of its rows | at once; several processes may share it |
//! | [`write_image`] | a buffer that is written to a stream | as it is drawn |
//!
//! [`Picture`] reads a binary PPM that any program wrote. [`NewFile`] is a file of
//! another format that appears whole.
//!
//! # What is promised
//!
//! These promises hold on Linux; the table in `tests/everywhere/README.md` says
//! which of them hold on other systems.
//!
//! **An image appears whole or not at all.** It is drawn into a file without a name
//! and gets its name when it is complete, in one step. Whatever happens before that,
//! a crash or `kill -9` included, an earlier image stays as it was and no other file
//! is left. A file `.sfera-*.part` beside the image is needed in two cases: for the
//! whole time where the file system has no files without a name (or there is no
//! `/proc`), and for a moment where an earlier image is replaced, since only a name
//! can be renamed. The program removes it however it ends, except by `kill -9`, a
//! crash of the machine, or a `SIGSEGV` in just that moment. A [`SharedImage`]
//! (`--rows`) is changed in place, which is its purpose.
//!
//! **A full disk is an error.** All blocks are reserved before the first pixel is
//! drawn. Some file systems can't promise that a reserved block can be written (all
//! but ext, XFS, F2FS and tmpfs, and those without `fallocate`). There, rows are
//! written instead of mapped: the bytes are the same, and a lack of room is an error.
//! A new [`SharedImage`] is filled with zeros there. The size of a PNG is not known
//! in advance, so there a full disk is reported when it is full.
//!
//! **Existing files are respected.**
//! - The program never overwrites the scene, under any name or link, nor one of the
//!   two images of `--diff` by the other. Only "not found" means that nothing is
//!   there.
//! - A write-protected file is not replaced, not even by root.
//! - A symbolic link stays, and its target is replaced. Other hard links to the old
//!   image keep the old image.
//! - A file is examined again before it is replaced. Between that and the rename
//!   there is a moment in which another process may still put something there.
//! - A [`SharedImage`] refuses a file that is not a picture of this size, and reports
//!   it if the file was removed or replaced while its rows were drawn.
//! - The program writes `/dev/stdout`, `/dev/fd/N` and the like through the
//!   descriptor, as it does `-`.
//!
//! **A replaced image gives nobody a new right.** It passes on the owner, the group,
//! the permissions, the access control list and the other extended attributes. What
//! may not be passed on is narrowed: where only root could keep the owner, the file
//! is the caller's, and everybody else can do at most what they could before. Nobody
//! else can read such an image until it has its name. A new image follows the umask
//! and the directory's default list; the owner can always write one that a
//! [`SharedImage`] makes, whatever the umask.
//!
//! **Memory does not grow with the picture.** A file is mapped a window at a time:
//! 32768 x 32768 takes 3 GiB of disk and 63 MB of memory, less than 1 MB of it the
//! process's own. The size in bytes may reach 2^63.
//!
//! # Limits
//!
//! - The image is handed to the operating system, not forced to the disk: run `sync`
//!   if the power may fail. Only a disk that is not local is waited for, since such a
//!   disk may report only then that it is full.
//! - Several machines may draw rows of one picture on a network file system, because
//!   there rows are written to the byte instead of mapped. All of them must see one
//!   file under one name, and the file system's own rules decide when each sees the
//!   others' bytes.
//! - If another process shortens a mapped file, the operating system sends `SIGBUS`;
//!   the program reports it and exits with 1.
//! - A row is never split: 4,294,967,295 columns need 13 GB of addresses, and for a
//!   stream as much memory.

mod draft;
mod errors;
mod event;
mod format;
mod map;
mod new;
mod new_file;
mod read;
mod rows;
mod shared;
mod stream;
mod system;
mod target;

pub use self::{
    errors::ImageError,
    event::{Event, Watch},
    format::header,
    new::MappedImage,
    new_file::NewFile,
    read::{Picture, row_groups},
    shared::SharedImage,
    stream::{try_write_image, write_image},
    target::Place,
};
