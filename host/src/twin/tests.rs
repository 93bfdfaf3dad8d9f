//! Synthetic robots, tables and trials.
