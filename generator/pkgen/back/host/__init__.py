"""The C interface `pk_host.h`, by which each host (a wheel, a crate, a page, ...) calls a model."""
