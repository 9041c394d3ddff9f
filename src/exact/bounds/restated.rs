//! What packets evaluate, stated again for a number that records it. A test of packets holds
//! both to the same bits.

use crate::exact::kernels::{Number, quadratic};

/// Terms of `d` and of `b` in a column `p` from the middle: `d0`, `d1`, `d2` and `b0`, `b1`.
pub(in crate::exact) fn in_column<N: Number>(
    [d00, d10, d01, d20, d11, d02]: [N; 6],
    [b00, b10, b01]: [N; 3],
    p: N,
) -> ([N; 3], [N; 2]) {
    (
        [quadratic([d00, d10, d20], p), d11.times_plus(p, d01), d02],
        [b10.times_plus(p, b00), b01],
    )
}

/// `d` and `b` in a row `q` from the middle.
pub(in crate::exact) fn in_row<N: Number>(d: [N; 3], [b0, b1]: [N; 2], q: N) -> [N; 2] {
    [quadratic(d, q), b1.times_plus(q, b0)]
}
