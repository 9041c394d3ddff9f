//! The image file, a binary PPM: reserve, map, publish.
//!
//! ```text
//! P6\nWIDTH HEIGHT\n255\n      then 3 bytes a pixel, rows from the top
//! ```
//!
//! There are three ways to an image, and all of them take their rows from one
//! closure, a group of whole rows at a time:
//!
//! | | draws into | appears |
//! | --- | --- | --- |
//! | [`MappedImage`] | a mapped file without a name | under its name, whole, in one step |
//! | [`SharedImage`] | the file itself, some of its rows | at once; several processes may share it |
//! | [`write_image`] | a buffer that is written to a stream | as it is drawn |
//!
//! [`Picture`] reads one, whoever wrote it. [`NewFile`] makes files of other formats
//! appear as whole.
//!
//! A file is mapped a window at a time, so neither the addresses nor the memory
//! that a picture takes grow with it. Its blocks are reserved first: a full disk
//! is an error to report, not a signal to die of. Where the file system can't promise
//! that, rows are written and not mapped.

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
    stream::write_image,
    target::Place,
};
