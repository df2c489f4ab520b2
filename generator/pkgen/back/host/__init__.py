"""The C interface `pk_host.h`, by which each host (Python wheel, Rust crate, page, ...) calls a
model."""
