//! What the picture means, one pixel at a time, in integers.
