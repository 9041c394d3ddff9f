//! Makes foreign text safe to show in messages: names of files, and their contents.

use std::path::Path;

/// The name of a file as a message shows it, on one line.
///
/// ```
/// assert_eq!(sfera::name::shown("two\nlines.ppm".as_ref()), "two\\x0alines.ppm");
/// ```
#[must_use]
pub fn shown(path: &Path) -> String {
    printable(path.as_os_str().as_encoded_bytes())
}

/// Printable text unchanged, a blank for a tab, and escapes for everything else: bytes that
/// are not UTF-8, controls, and characters that reorder or hide others.
#[must_use]
pub fn printable(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len());
    for piece in bytes.utf8_chunks() {
        for character in piece.valid().chars() {
            match character {
                '\t' => text.push(' '),
                '\'' | '"' | '\\' => text.push(character),
                '\0' => text.push_str("\\x00"),
                _ if character.is_ascii_control() => {
                    text.push_str(&format!("\\x{:02x}", u32::from(character)));
                }
                _ => text.extend(character.escape_debug()),
            }
        }
        for byte in piece.invalid() {
            text.push_str(&format!("\\x{byte:02x}"));
        }
    }
    text
}
