"""The one interface of a model in C, `pk_host.h`, by which all hosts call it."""
