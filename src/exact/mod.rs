//! The engine: every pixel proven right.
