//! Compares shadows with ray-traced truth.
