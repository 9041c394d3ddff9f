//! Files of other kinds that are given as scenes.

/// A kind of file.
struct Signature {
    /// The bytes that it begins with.
    begin: &'static [u8],
    name: &'static str,
    help: &'static str,
}

const UNPACK: &str = "unpack it first";
const SAVE_AS_UTF8: &str = "save it as UTF-8 or as ASCII";
const NAME_A_TEXT: &str = "name a scene, a text that begins with VP";
const NOT_THE_IMAGE: &str =
    "name a scene, a text that begins with VP; the image is the second argument";
const OTHER_FORMAT: &str = "a scene is a text of VP, BG, OBJ_N and S lines";

/// A signature stands before those that it begins like.
const SIGNATURES: [Signature; 21] = [
    signature(b"\xff\xfe\0\0", "a text in UTF-32", SAVE_AS_UTF8),
    signature(b"\xff\xfe", "a text in UTF-16", SAVE_AS_UTF8),
    signature(b"\xfe\xff", "a text in UTF-16", SAVE_AS_UTF8),
    signature(b"V\0", "a text in UTF-16", SAVE_AS_UTF8),
    signature(b"\0V", "a text in UTF-16", SAVE_AS_UTF8),
    signature(b"\x1f\x8b", "a gzip archive", UNPACK),
    signature(b"PK\x03\x04", "a zip archive", UNPACK),
    signature(b"\x28\xb5\x2f\xfd", "a Zstandard archive", UNPACK),
    signature(b"\xfd7zXZ", "an xz archive", UNPACK),
    signature(b"BZh", "a bzip2 archive", UNPACK),
    signature(b"7z\xbc\xaf", "a 7-Zip archive", UNPACK),
    signature(b"P6", "a PPM image", NOT_THE_IMAGE),
    signature(b"P3", "a PPM image", NOT_THE_IMAGE),
    signature(b"P5", "a PGM image", NOT_THE_IMAGE),
    signature(b"\x89PNG", "a PNG image", NOT_THE_IMAGE),
    signature(b"\xff\xd8\xff", "a JPEG image", NOT_THE_IMAGE),
    signature(b"GIF8", "a GIF image", NOT_THE_IMAGE),
    signature(b"\x7fELF", "a program", NAME_A_TEXT),
    signature(b"%PDF", "a PDF document", NAME_A_TEXT),
    signature(b"{", "JSON", OTHER_FORMAT),
    signature(b"<", "XML or HTML", OTHER_FORMAT),
];

const fn signature(begin: &'static [u8], name: &'static str, help: &'static str) -> Signature {
    Signature { begin, name, help }
}

/// The kind of a file that begins with this word, and what to do about it.
pub(super) fn kind(word: &[u8]) -> Option<(&'static str, &'static str)> {
    SIGNATURES
        .iter()
        .find(|signature| word.starts_with(signature.begin))
        .map(|signature| (signature.name, signature.help))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, SceneErrorKind};

    #[test]
    fn each_signature_is_recognised_at_the_beginning_and_nowhere_else() {
        for Signature { begin, name, help } in SIGNATURES {
            let refused = |text: &[u8]| Scene::parse(text).expect_err("not a scene");
            let error = refused(&[begin, b" 1 2 3"].concat());
            assert!(matches!(error.kind(), SceneErrorKind::NotAScene), "{error}");
            let message = error.to_string();
            assert!(
                message.contains(&format!("expected a scene, found {name}\n")),
                "{message}"
            );
            assert!(message.ends_with(&format!("\nhelp: {help}")), "{message}");

            let later = refused(&[b"VP 1 1 1 ", begin].concat());
            assert!(
                !matches!(later.kind(), SceneErrorKind::NotAScene),
                "{later}"
            );
        }
    }
}
