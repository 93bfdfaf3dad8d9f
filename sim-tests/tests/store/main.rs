//! What survives power-off.

mod amplitudes;
mod cuts;
mod gaits;

mod torn;
