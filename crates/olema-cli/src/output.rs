//! Where a picture goes.
//!
//! Scene files are untrusted, and a picture is written only where the user said: to `-o`, or into the current
//! directory under a name that the scene may suggest but that is reduced to a plain file name ending in .png.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::exit::{self, Failure};

/// Name that RenderMan gives a picture when the scene names none.
const RENDERMAN_DEFAULT: &str = "ri.pic";

/// Endings that name a picture format and are replaced by .png; any other dot is part of the name.
const PICTURE_ENDINGS: [&str; 18] = [
    "png", "tif", "tiff", "exr", "pic", "jpg", "jpeg", "gif", "bmp", "tga", "rla", "sgi", "hdr", "ppm",
    "pnm", "z", "zfile", "rgb",
];

/// What is known of a picture before it has a name.
#[derive(Debug, Clone, Copy)]
pub struct Subject<'a> {
    /// The scene, as the user named it.
    pub scene: &'a Path,
    /// The scene's Display name.
    pub display: &'a str,
    /// Number of the frame.
    pub frame: i32,
}

/// Gives pictures their names, never the same one twice in a run.
#[derive(Debug)]
pub struct Names {
    /// `-o`, checked.
    output: Option<PathBuf>,
    given: HashSet<PathBuf>,
}

impl Names {
    /// Checks `-o` before hours are spent on a picture that cannot be written.
    ///
    /// # Errors
    /// A usage failure where `-o` names no .png, a missing directory or something that is no plain file.
    pub fn new(output: Option<&Path>) -> Result<Self, Failure> {
        if let Some(path) = output
            && !is_directory(path)
        {
            check_target("-o", path)?;
        }
        Ok(Names { output: output.map(Path::to_owned), given: HashSet::new() })
    }

    /// The path for this picture.
    ///
    /// # Errors
    /// A usage failure where `-o` gives this frame the name that another picture of this run has.
    pub fn name(&mut self, subject: Subject) -> Result<PathBuf, Failure> {
        let path = match &self.output {
            Some(output) if !is_directory(output) => {
                let path = PathBuf::from(with_frame_number(&output.to_string_lossy(), subject.frame));
                if self.given.contains(&path) {
                    let problem = format!(
                        "-o {}: frame {} of {} would replace another picture of this run; put #### or %04d \
                         for the frame's number into the name, or name a directory",
                        output.display(),
                        subject.frame,
                        subject.scene.display()
                    );
                    return Err(Failure::new(exit::USAGE, problem));
                }
                path
            }
            directory => {
                let directory = directory.clone().unwrap_or_default();
                let path =
                    self.unused(&directory, &plain_name(subject.display, subject.scene), subject.frame);
                refuse_link(&path)?;
                path
            }
        };
        check_target("-o", &path)?;
        self.given.insert(path.clone());
        Ok(path)
    }

    /// `stem.png` in the directory; with the frame's number, then with a count, where that was given already.
    fn unused(&self, directory: &Path, stem: &str, frame: i32) -> PathBuf {
        let first = std::iter::once(format!("{stem}.png"));
        let numbered = std::iter::once(format!("{stem}.{frame:04}.png"));
        let counted = (2..).map(|n| format!("{stem}.{frame:04}.{n}.png"));
        let mut candidates = first.chain(numbered).chain(counted).map(|name| directory.join(name));
        candidates.find(|path| !self.given.contains(path)).unwrap_or_default()
    }
}

/// Whether `-o` names a directory: one that is there, or a name that ends like one.
fn is_directory(path: &Path) -> bool {
    path.is_dir()
        || path.as_os_str().as_encoded_bytes().last().is_some_and(|b| std::path::is_separator(*b as char))
}

/// A scene may come with a link beside it; a name that the scene chose must not lead elsewhere through one.
fn refuse_link(path: &Path) -> Result<(), Failure> {
    if path.is_symlink() {
        let problem = format!("{}: is a link; say -o {0} if it is to be written through", path.display());
        return Err(Failure::new(exit::RENDER, problem));
    }
    Ok(())
}

/// Checks that a picture can be written to `path`: a name in .png in a directory that is there, or a device.
///
/// # Errors
/// A usage failure that begins with the option's name.
pub fn check_target(option: &str, path: &Path) -> Result<(), Failure> {
    let named_png = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    let problem = if path.is_dir() {
        "is a directory".to_owned()
    } else if path.exists() && !path.is_file() {
        return Ok(());
    } else if !named_png {
        "expected a name that ends in .png, the only format written".to_owned()
    } else {
        match check_directory(path) {
            Ok(()) => return Ok(()),
            Err(problem) => problem,
        }
    };
    Err(Failure::new(exit::USAGE, format!("{option} {}: {problem}", path.display())))
}

/// Checks that a file may be renamed to `path`: its directory is there, and nothing but a plain file is in the
/// way.
///
/// # Errors
/// What is wrong.
pub fn check_place(path: &Path) -> Result<(), String> {
    if path.exists() && !path.is_file() {
        return Err("is not a plain file and will not be replaced".to_owned());
    }
    check_directory(path)
}

fn check_directory(path: &Path) -> Result<(), String> {
    let directory = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if directory.is_dir() {
        Ok(())
    } else {
        Err(format!("the directory {} does not exist", directory.display()))
    }
}

/// Puts the frame's number for each run of `#` (as wide as the run) and each `%d`, `%4d`, `%04d`; `%%` is `%`.
pub fn with_frame_number(pattern: &str, frame: i32) -> String {
    let mut out = String::new();
    let mut rest = pattern;
    while let Some(at) = rest.find(['#', '%']) {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let hashes = rest.len() - rest.trim_start_matches('#').len();
        if hashes > 0 {
            out.push_str(&format!("{frame:0hashes$}"));
            rest = &rest[hashes..];
        } else if let Some(after) = rest.strip_prefix("%%") {
            out.push('%');
            rest = after;
        } else if let Some((width, zeros, after)) = percent_d(&rest[1..]) {
            out.push_str(&if zeros { format!("{frame:0width$}") } else { format!("{frame:width$}") });
            rest = after;
        } else {
            out.push('%');
            rest = &rest[1..];
        }
    }
    out.push_str(rest);
    out
}

/// What follows the `%` of `%d`, `%4d`, `%04d`: width, whether zeros fill it, and the rest.
fn percent_d(s: &str) -> Option<(usize, bool, &str)> {
    let (digits, after) = s.split_once('d')?;
    // Two digits: no width beyond what a file name can hold.
    if digits.len() > 2 || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    Some((digits.parse().unwrap_or(0), digits.starts_with('0'), after))
}

/// A file name without directory or ending from what a scene calls its picture, or from the scene's own name.
pub fn plain_name(display: &str, scene: &Path) -> String {
    let named = if display == RENDERMAN_DEFAULT { String::new() } else { tamed(display) };
    if !named.is_empty() {
        return named;
    }
    let stem = |p: &Path| p.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    // teapot.rib.gz -> teapot
    let named = tamed(&stem(Path::new(&stem(scene))));
    if named.is_empty() || named == "-" { "olema".to_owned() } else { named }
}

/// The last part of a path of any system, without a picture's ending and without what file systems, shells
/// and terminals stumble over.
fn tamed(path: &str) -> String {
    let name = path.rsplit(['/', '\\']).next().unwrap_or_default().trim();
    let name = match name.rsplit_once('.') {
        Some((stem, ending)) if PICTURE_ENDINGS.contains(&ending.to_ascii_lowercase().as_str()) => stem,
        _ => name,
    };
    let safe = |c: char| if c.is_control() || r#"<>:"|?*"#.contains(c) { '_' } else { c };
    // Long names are cut: file systems end at 255 bytes, and ".0001.png" and a temporary name come on top.
    let name: String = name.chars().map(safe).take(60).collect();
    // No hidden files, no "..", no name that reads as an option.
    name.trim_start_matches(['.', '-']).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn subject(display: &str, frame: i32) -> Subject<'_> {
        Subject { scene: Path::new("dir/teapot.rib"), display, frame }
    }

    #[test]
    fn frame_numbers_fill_patterns() {
        assert_eq!(with_frame_number("a.####.png", 7), "a.0007.png");
        assert_eq!(with_frame_number("a#.png", 123), "a123.png");
        assert_eq!(with_frame_number("a.%04d.png", 7), "a.0007.png");
        assert_eq!(with_frame_number("a.%d.png", 7), "a.7.png");
        assert_eq!(with_frame_number("a.%3d.png", 7), "a.  7.png");
        assert_eq!(with_frame_number("100%%.%s.png", 7), "100%.%s.png");
        assert_eq!(with_frame_number("##/%02d.png", 7), "07/07.png");
        assert_eq!(with_frame_number("é%", 7), "é%");
        assert_eq!(with_frame_number("%999999999d.png", 7), "%999999999d.png");
    }

    #[test]
    fn a_scene_never_chooses_a_directory() {
        for (display, name) in [
            ("/etc/passwd", "passwd"),
            ("../../up.tif", "up"),
            ("..", "teapot"),
            ("a/..", "teapot"),
            ("C:\\windows\\evil.exr", "evil"),
            ("C:evil", "C_evil"),
            (".bashrc", "bashrc"),
            ("-rf.png", "rf"),
            ("", "teapot"),
            ("ri.pic", "teapot"),
            ("shot.v2", "shot.v2"),
            ("shot.v2.TIFF", "shot.v2"),
            ("a\u{1b}[2Jb\n.png", "a_[2Jb_"),
            ("dir/", "teapot"),
        ] {
            assert_eq!(plain_name(display, Path::new("dir/teapot.rib.gz")), name, "{display:?}");
        }
        assert_eq!(plain_name("", Path::new("-")), "olema");
        assert!(plain_name(&"é".repeat(1000), Path::new("-")).len() <= 120);
    }

    #[test]
    fn pictures_of_one_run_never_share_a_name_of_the_scenes_choice() {
        let mut names = Names::new(None).unwrap();
        let given = [1, 2, 2, 2].map(|f| names.name(subject("x.tif", f)).unwrap());
        assert_eq!(given, ["x.png", "x.0002.png", "x.0002.2.png", "x.0002.3.png"].map(PathBuf::from));
    }

    #[test]
    fn an_output_without_a_pattern_takes_one_picture() {
        let mut names = Names::new(Some(Path::new("one.png"))).unwrap();
        assert_eq!(names.name(subject("x", 1)), Ok(PathBuf::from("one.png")));
        let failure = names.name(subject("x", 2)).unwrap_err();
        assert_eq!(failure.code, exit::USAGE);
        assert!(failure.message.contains("####"), "{}", failure.message);
    }

    #[test]
    fn outputs_that_cannot_be_written_are_refused_early() {
        for (path, word) in
            [("a.exr", "ends in .png"), ("a", "ends in .png"), ("no/such/dir/a.png", "does not exist")]
        {
            let failure = Names::new(Some(Path::new(path))).unwrap_err();
            assert_eq!(failure.code, exit::USAGE);
            assert!(failure.message.contains(word), "{}", failure.message);
        }
        assert!(check_place(Path::new("/")).unwrap_err().contains("plain file"));
        #[cfg(unix)]
        {
            assert!(check_place(Path::new("/dev/null")).unwrap_err().contains("plain file"));
            assert_eq!(check_target("-o", Path::new("/dev/null")), Ok(()));
        }
    }

    #[test]
    fn a_directory_takes_the_scenes_names() {
        let mut names = Names::new(Some(Path::new("."))).unwrap();
        assert_eq!(names.name(subject("/tmp/x.tif", 1)), Ok(Path::new(".").join("x.png")));
    }
}
