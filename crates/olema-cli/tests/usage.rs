//! Help, wrong arguments, exit codes that need no scene.

mod common;

use common::Bench;

#[test]
fn help_and_version_succeed() {
    let bench = Bench::new();
    for args in [&["--help"][..], &["render", "--help"], &["info", "-h"], &["diff", "--help"], &["--version"]]
    {
        let ran = bench.run(args);
        assert_eq!(ran.code, 0, "{args:?}: {}", ran.err);
        assert!(ran.err.is_empty());
    }
    assert!(bench.run(&["--version"]).out.starts_with("olema 0."));
    assert!(bench.run(&["render", "--help"]).out.contains("Exit codes"));
}

#[test]
fn wrong_arguments_exit_2_and_name_the_option_and_what_was_expected() {
    let bench = Bench::new();
    for (args, words) in [
        (&["render"][..], ["<FILE>", "required"]),
        (&["render", "a.rib", "--res", "640"], ["--res", "WIDTHxHEIGHT"]),
        (&["render", "a.rib", "--res", "0x480"], ["--res", "1 to 65535"]),
        (&["render", "a.rib", "--spp", "0"], ["--spp", "1..=1024"]),
        (&["render", "a.rib", "--spp", "1025"], ["--spp", "1..=1024"]),
        (&["render", "a.rib", "--samples", "64x64"], ["--samples", "1 to 1024"]),
        (&["render", "a.rib", "--spp", "4", "--samples", "2x2"], ["--spp", "cannot be used with"]),
        (&["render", "a.rib", "--shading-rate", "-1"], ["-1", ""]),
        (&["render", "a.rib", "--shading-rate=-1"], ["--shading-rate", "above 0"]),
        (&["render", "a.rib", "--shading-rate", "nan"], ["--shading-rate", "above 0"]),
        (&["render", "a.rib", "--crop", "0,1,0"], ["--crop", "x0,x1,y0,y1"]),
        (&["render", "a.rib", "--crop", "-1,1,0,1"], ["--crop", "x0,x1,y0,y1"]),
        (&["render", "a.rib", "--threads", "many"], ["--threads", "invalid"]),
        (&["render", "a.rib", "--bucket", "0"], ["--bucket", "NxM"]),
        (&["render", "a.rib", "--tile", "5"], ["--tile", "1, 2, 3, 4, 8 or 64"]),
        (&["render", "a.rib", "--rasterizer", "fast"], ["--rasterizer", "auto, nomotion, interval"]),
        (&["render", "a.rib", "--motion-factor=-1"], ["--motion-factor", "at least 0"]),
        (&["render", "a.rib", "--focus-factor", "nan"], ["--focus-factor", "at least 0"]),
        (&["render", "a.rib", "--shutter", "1,0"], ["--shutter", "OPEN,CLOSE"]),
        (&["render", "a.rib", "--shutter", "-inf,0"], ["--shutter", "OPEN,CLOSE"]),
        (&["render", "a.rib", "--shading-time", "noon"], ["--shading-time", "middle"]),
        (&["render", "a.rib", "--frames", "7-1"], ["--frames", "1-7:2,20-25"]),
        (&["render", "a.rib", "--progress", "loud"], ["--progress", "plain"]),
        (&["render", "a.rib", "--quiet", "--verbose"], ["--quiet", "cannot be used with"]),
        (&["render", "a.rib", "-o", "a.exr"], ["-o a.exr", ".png"]),
        (&["render", "a.rib", "-o", "no/a.png"], ["-o no/a.png", "does not exist"]),
        (&["render", "a.rib", "--stats", "no/s.json"], ["--stats no/s.json", "does not exist"]),
        (&["render", "a.rib", "--search-path", "no"], ["--search-path no", "directory"]),
        (&["render", "-", "-"], ["standard input", "once"]),
        (&["info"], ["<FILE>", "required"]),
        (&["diff", "a.png"], ["<B>", "required"]),
        (&["diff", "a.png", "b.png", "--tolerance", "256"], ["--tolerance", "0 to 255"]),
        (&["paint"], ["paint", "unrecognized"]),
    ] {
        let ran = bench.run(args);
        assert_eq!(ran.code, 2, "{args:?}: {}{}", ran.out, ran.err);
        for word in words {
            assert!(ran.err.contains(word), "{args:?}: {word:?} is not in {}", ran.err);
        }
        assert!(ran.out.is_empty());
    }
    assert!(bench.names().is_empty());
}

#[cfg(unix)]
#[test]
fn statistics_never_replace_a_device() {
    let ran = Bench::new().run(&["render", "a.rib", "--stats", "/dev/null"]);
    assert_eq!(ran.code, 2);
    assert!(ran.err.contains("not a plain file"), "{}", ran.err);
}
