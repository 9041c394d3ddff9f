//! Whether this CPU has all that the program was compiled for.

macro_rules! first_missing {
    ($($feature:tt),* $(,)?) => {
        None$(.or_else(|| {
            (cfg!(target_feature = $feature) && !std::arch::is_x86_feature_detected!($feature))
                .then_some($feature)
        }))*
    };
}

/// The first feature that the compiler was allowed to use and this CPU lacks:
/// its instructions would end the program with a signal.
#[inline(never)]
pub(crate) fn missing_feature() -> Option<&'static str> {
    #[cfg(target_arch = "x86_64")]
    return first_missing!(
        "sse3",
        "ssse3",
        "sse4.1",
        "sse4.2",
        "popcnt",
        "avx",
        "avx2",
        "fma",
        "bmi1",
        "bmi2",
        "lzcnt",
        "movbe",
        "f16c",
        "sse4a",
        "adx",
        "aes",
        "pclmulqdq",
        "rdrand",
        "rdseed",
        "sha",
        "gfni",
        "vaes",
        "vpclmulqdq",
        "fxsr",
        "xsave",
        "xsavec",
        "xsaveopt",
        "xsaves",
        "avx512f",
        "avx512bw",
        "avx512cd",
        "avx512dq",
        "avx512vl",
        "avx512ifma",
        "avx512vbmi",
        "avx512vbmi2",
        "avx512vnni",
        "avx512bitalg",
        "avx512vpopcntdq",
        "avx512bf16",
    );
    #[cfg(not(target_arch = "x86_64"))]
    return None;
}
