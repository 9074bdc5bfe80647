//! Readers and writers for Olema.
