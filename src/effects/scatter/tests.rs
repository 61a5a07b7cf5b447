mod pencil;
mod superposed;
mod truth;
mod whole;
