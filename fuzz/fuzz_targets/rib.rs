//! Any bytes as a RIB file: no panic, no hang, bounded memory.
//!
//! `cargo fuzz run rib corpus/rib seeds/rib -- -dict=rib.dict` with a nightly compiler; with a stable one
//! `RUSTC_BOOTSTRAP=1 cargo fuzz run -s none rib ...`.

#![no_main]

use std::io::Cursor;

use libfuzzer_sys::fuzz_target;
use olema_formats::rib::{ReadOptions, RibReader};

fuzz_target!(|data: &[u8]| {
    // An absolute path could name any file of this machine; archives are another test's business.
    let options = ReadOptions { memory: 1 << 17, archive_depth: 8, ..ReadOptions::default() };
    let mut reader = RibReader::from_stream("fuzz", Box::new(Cursor::new(data.to_vec())), options);
    while let Ok(Some(frame)) = reader.next_frame() {
        frame.settings.validate().expect("settings that can be rendered");
        frame.scene.validate().expect("a scene that can be rendered");
        for primitive in &frame.scene.primitives {
            assert!(primitive.to_world.first().inverse().is_finite());
            // Wherever the keys lie, there is a matrix.
            primitive.to_world.at(0.3);
        }
    }
    reader.take_diagnostics();
});
