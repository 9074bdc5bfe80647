//! Image files: PNG with 8 bits a channel.
