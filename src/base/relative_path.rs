//! File names as seen from another folder.

use std::path::{Component, Path, PathBuf};

/// `name`, a file name relative to `folder`, as it must be written to mean the same file in `out`. Absolute names stay;
/// so do all names if both are one folder. Folders that don't exist are compared by their names.
pub fn relocated(name: &str, folder: &Path, out: &Path) -> String {
    if Path::new(name).is_absolute() {
        return name.to_owned();
    }
    if relative(out, folder).as_os_str().is_empty() {
        return name.to_owned();
    }
    let file = folder.join(name);
    match file.file_name() {
        // By the folder that the file really stands in: names don't grow by going there and back.
        Some(last) => slashed(&relative(out, &folder_of(&file)).join(last)),
        None => slashed(&relative(out, folder).join(name)),
    }
}

/// The way from the folder `from` to `to`; empty if they are the same. Without a common root it is `to`, absolute.
pub fn relative(from: &Path, to: &Path) -> PathBuf {
    let (from, to) = (whole(from), whole(to));
    let mut left = from.components().peekable();
    let mut right = to.components().peekable();
    if left.peek() != right.peek() {
        return to;
    }
    while let (Some(a), Some(b)) = (left.peek(), right.peek())
        && a == b
    {
        left.next();
        right.next();
    }
    let mut way: PathBuf = left.map(|_| Component::ParentDir).collect();
    way.extend(right);
    way
}

/// The folder that a file stands in, `.` for a bare name.
pub fn folder_of(file: &Path) -> PathBuf {
    match file.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        Some(_) | None => PathBuf::from("."),
    }
}

/// A path with `/` between its parts, as files that travel write it.
pub fn slashed(path: &Path) -> String {
    let parts: Vec<String> = path
        .components()
        .filter(|part| *part != Component::RootDir && *part != Component::CurDir)
        .map(|part| part.as_os_str().to_string_lossy().into_owned())
        .collect();
    let root = if path.has_root() { "/" } else { "" };
    format!("{root}{}", parts.join("/"))
}

/// A file by the folder that it really stands in: absolute, without `.`, `..` and links on the way. A file that is a link itself
/// keeps its name: what it names is relative to where the link stands.
pub fn placed(file: &Path) -> PathBuf {
    match file.file_name() {
        Some(name) => whole(&folder_of(file)).join(name),
        None => whole(file),
    }
}

/// Absolute, links resolved as far as the path exists, without `.` and `..`.
fn whole(path: &Path) -> PathBuf {
    if let Ok(real) = path.canonicalize() {
        return real;
    }
    match (path.parent(), path.file_name()) {
        (Some(parent), Some(name)) if !parent.as_os_str().is_empty() => whole(parent).join(name),
        (Some(_), Some(name)) => std::env::current_dir().map_or_else(|_| path.to_owned(), |here| here.join(name)),
        (_, None) | (None, _) => std::path::absolute(path).unwrap_or_else(|_| path.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_lead_to_the_same_file_from_elsewhere() {
        let root = tempfile::tempdir().unwrap();
        let (a, b) = (root.path().join("a"), root.path().join("b/c"));
        std::fs::create_dir_all(&a).unwrap();
        std::fs::create_dir_all(&b).unwrap();
        assert_eq!(relocated("x y.png", &a, &b), "../../a/x y.png");
        assert_eq!(relocated("x.png", &b, root.path()), "b/c/x.png");
        assert_eq!(relocated("../x.png", &a, &a.join("../a")), "../x.png");
        assert_eq!(relocated("/abs/x.png", &a, &b), "/abs/x.png");
        assert_eq!(relocated("x.png", &root.path().join("none/n"), &root.path().join("none")), "n/x.png");
        let file = b.join(relocated("x.png", &a, &b));
        std::fs::write(a.join("x.png"), b"!").unwrap();
        assert_eq!(std::fs::read(file).unwrap(), b"!");
        assert_eq!(folder_of(Path::new("x.glb")), Path::new("."));
        // There and back is the folder itself.
        let real = root.path().canonicalize().unwrap();
        assert_eq!(placed(&b.join("../../a/x.png")), real.join("a/x.png"));
        assert_eq!(placed(&b.join("..")), real.join("b"));
    }
}
