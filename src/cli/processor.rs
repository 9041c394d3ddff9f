//! Whether this CPU has every feature that the program was compiled for.

use std::io::{self, Write};

/// The first feature that the compiler was allowed to use and this CPU lacks. An
/// instruction of it would end the program with a signal.
///
/// This tests the bits of CPUID one by one, because `is_x86_feature_detected!` is always
/// true for a feature that was compiled in. It consists of tests of constants only, so that
/// the compiler has nothing to vectorise.
#[cfg(target_arch = "x86_64")]
#[inline(never)]
pub(crate) fn missing_feature() -> Option<&'static str> {
    use std::arch::x86_64::{__cpuid, __cpuid_count};

    macro_rules! check {
        ($register:expr; $($feature:tt $bit:literal),* $(,)?) => {
            $(if cfg!(target_feature = $feature) && $register & (1 << $bit) == 0 {
                return Some($feature);
            })*
        };
    }

    let basic = __cpuid(1);
    check!(basic.edx; "fxsr" 24);
    // "avx": bit 28, and 27, that the operating system saves its registers.
    check!(basic.ecx; "sse3" 0, "pclmulqdq" 1, "ssse3" 9, "fma" 12, "cmpxchg16b" 13, "sse4.1" 19,
        "sse4.2" 20, "movbe" 22, "popcnt" 23, "aes" 25, "xsave" 26, "avx" 27, "avx" 28, "f16c" 29,
        "rdrand" 30);
    let extended = __cpuid(0x8000_0001);
    check!(extended.ecx; "lahfsahf" 0, "lzcnt" 5, "sse4a" 6, "tbm" 21);
    if __cpuid(0).eax < 7 {
        return cfg!(target_feature = "avx2").then_some("avx2");
    }
    let structured = __cpuid_count(7, 0);
    check!(structured.ebx; "bmi1" 3, "avx2" 5, "bmi2" 8, "avx512f" 16, "avx512dq" 17, "rdseed" 18,
        "adx" 19, "avx512ifma" 21, "avx512cd" 28, "sha" 29, "avx512bw" 30, "avx512vl" 31);
    check!(structured.ecx; "avx512vbmi" 1, "avx512vbmi2" 6, "gfni" 8, "vaes" 9, "vpclmulqdq" 10,
        "avx512vnni" 11, "avx512bitalg" 12, "avx512vpopcntdq" 14);
    check!(structured.edx; "avx512vp2intersect" 8, "avx512fp16" 23);
    let more = __cpuid_count(7, 1);
    check!(more.eax; "avxvnni" 4, "avx512bf16" 5, "avxifma" 23);
    None
}

/// Other CPUs are not checked.
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn missing_feature() -> Option<&'static str> {
    None
}

/// Reports a missing feature. The standard library is compiled for any CPU of this kind, and
/// calls with one text each leave the compiler nothing to vectorise. The functions for other
/// messages would use the missing feature.
pub(crate) fn report(feature: &str) {
    write("sfera: this program was built for a CPU with ");
    write(feature);
    write(", which this one lacks; build it again on this machine (make build)\n");
}

#[inline(never)]
fn write(text: &str) {
    let _ = io::stderr().write_all(text.as_bytes());
}
