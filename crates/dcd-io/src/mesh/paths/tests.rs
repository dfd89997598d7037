use super::*;

/// A folder that is gone with the test.
struct Folder(PathBuf);

impl Folder {
    /// With these files in it, each with its text.
    fn with(files: &[(&str, &str)]) -> Self {
        use std::sync::atomic::{AtomicU32, Ordering};
        static NEXT: AtomicU32 = AtomicU32::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let name = format!("dcd-paths-{}-{number}", std::process::id());
        let folder = Self(std::env::temp_dir().join(name));
        for (path, text) in files {
            let path = folder.0.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        folder
    }

    fn paths(&self, folder: &str) -> MeshPaths {
        MeshPaths::new(&self.0.join(folder))
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        std::fs::remove_dir_all(&self.0).ok();
    }
}

const PACKAGE: &str = "<package format=\"2\"><name> arm_description </name></package>";

#[test]
fn a_package_is_a_folder_of_its_name_beside_or_above() {
    let folder = Folder::with(&[("ws/arm/meshes/a.stl", ""), ("ws/arm/urdf/arm.urdf", "")]);
    for from in ["ws/arm/urdf", "ws/arm", "ws", "ws/other/deep/down"] {
        let found = folder.paths(from).resolve("package://arm/meshes/a.stl");
        assert_eq!(found.unwrap(), folder.0.join("ws/arm/meshes/a.stl"), "{from}");
    }
    let model = folder.paths("ws").resolve("model://arm/meshes/a.stl");
    assert_eq!(model.unwrap(), folder.0.join("ws/arm/meshes/a.stl"));
}

#[test]
fn a_package_is_also_a_folder_whose_package_xml_names_it() {
    let folder = Folder::with(&[
        ("checkout/package.xml", PACKAGE),
        ("checkout/meshes/a.stl", ""),
        ("bringup/urdf/arm.urdf", ""),
    ]);
    for from in ["checkout/urdf/inner", "checkout", "bringup/urdf"] {
        let found = folder.paths(from).resolve("package://arm_description/meshes/a.stl");
        assert_eq!(found.unwrap(), folder.0.join("checkout/meshes/a.stl"), "{from}");
    }
}

#[test]
fn a_package_that_is_given_is_no_other() {
    let folder = Folder::with(&[("arm/a.stl", ""), ("mine/a.stl", ""), ("old/b.stl", "")]);
    let paths = folder.paths("").with_package("arm", folder.0.join("old"));
    // The last said of a name counts.
    let mine = paths.clone().with_package("arm", folder.0.join("mine"));
    assert_eq!(mine.resolve("package://arm/a.stl").unwrap(), folder.0.join("mine/a.stl"));
    let refused = paths.resolve("package://arm/a.stl").unwrap_err();
    assert_eq!(refused.looked_in, [folder.0.join("old/a.stl")]);
}

#[test]
fn roots_are_searched_for_packages_before_what_is_beside() {
    let folder = Folder::with(&[
        ("root/repository/checkout/package.xml", PACKAGE),
        ("root/repository/checkout/a.stl", ""),
        ("urdf/arm_description/a.stl", ""),
        ("urdf/arm_description/b.stl", ""),
    ]);
    for root in ["root", "root/repository", "root/repository/checkout"] {
        let paths = folder.paths("urdf").with_roots([PathBuf::new(), folder.0.join(root)]);
        let found = paths.resolve("package://arm_description/a.stl").unwrap();
        assert_eq!(found, folder.0.join("root/repository/checkout/a.stl"), "{root}");
        // What the root's package lacks may be beside.
        assert!(paths.resolve("package://arm_description/b.stl").is_ok());
    }
    let plain = Folder::with(&[("share/arm/a.stl", "")]);
    let paths = folder.paths("urdf").with_roots([plain.0.clone()]);
    assert!(paths.resolve("package://arm/a.stl").is_ok());
}

#[test]
fn plain_and_absolute_names_and_those_of_files_are_found() {
    let folder = Folder::with(&[("robot/meshes/a b.stl", ""), ("robot/urdf/x.urdf", "")]);
    let file = folder.0.join("robot/meshes/a b.stl");
    let absolute = file.to_str().unwrap();
    for name in [
        "meshes/a b.stl".to_owned(),
        "../meshes/a b.stl".to_owned(),
        "file://meshes/a%20b.stl".to_owned(),
        absolute.to_owned(),
        format!("file://{absolute}"),
        format!("file://{}", absolute.replace(' ', "%20")),
    ] {
        let found = folder.paths("robot/urdf").resolve(&name);
        let found = found.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(found.canonicalize().unwrap(), file.canonicalize().unwrap(), "{name}");
    }
    assert_eq!(folder.paths("robot/urdf").resolve("package:///a b.stl").ok(), None);
}

#[test]
fn what_is_not_found_lists_where_was_looked() {
    let folder = Folder::with(&[("a/b/x.urdf", "")]);
    let error = folder.paths("a/b").resolve("package://arm/meshes/no.stl").unwrap_err();
    let text = error.to_string();
    for place in ["a/b/arm/meshes/no.stl", "a/arm/meshes/no.stl", "a/b/meshes/no.stl"] {
        assert!(text.contains(folder.0.join(place).to_str().unwrap()), "{place}: {text}");
    }
    assert!(text.contains("--package"), "{text}");
    let plain = folder.paths("a/b").resolve("/no/such.stl").unwrap_err();
    assert_eq!(plain.looked_in, [Path::new("/no/such.stl")]);
    for name in ["http://x/y.stl", "package://arm"] {
        let error = folder.paths("a/b").resolve(name).unwrap_err();
        assert!(error.to_string().contains("names no file"), "{error}");
    }
}

#[test]
fn percent_signs_that_mean_no_byte_stay() {
    for (text, decoded) in [
        ("a%20b", "a b"),
        ("%", "%"),
        ("%4", "%4"),
        ("%zz%41", "%zzA"),
        ("%ff", "%ff"),
        ("é%c3%a9", "éé"),
    ] {
        assert_eq!(percent_decoded(text), decoded);
    }
}

#[test]
fn a_file_of_a_package_is_in_it_whatever_slashes_are_before_it() {
    let folder = Folder::with(&[("arm/m/a.stl", ""), ("other/b.stl", "")]);
    let outside = folder.0.join("other/b.stl");
    let outside = outside.to_str().unwrap().trim_start_matches('/');
    let given = folder.paths("other").with_package("arm", folder.0.join("arm"));
    for name in ["package://arm//m/a.stl", "package://arm/%2Fm%2Fa.stl", "model://arm///m/a.stl"] {
        for paths in [&given, &folder.paths("other")] {
            assert_eq!(paths.resolve(name).unwrap(), folder.0.join("arm/m/a.stl"), "{name}");
        }
    }
    for before in ["package://arm//", "package://arm/%2F"] {
        let refused = given.resolve(&format!("{before}{outside}"));
        assert_eq!(refused.ok(), None, "{before}{outside}");
    }
}

#[test]
fn a_folder_is_the_package_that_its_package_xml_names_and_no_other() {
    let folder = Folder::with(&[
        ("ws/arm_description/package.xml", "<package><name>old_arm</name></package>"),
        ("ws/arm_description/a.stl", ""),
        ("ws/checkout/package.xml", PACKAGE),
        ("ws/checkout/a.stl", ""),
        ("ws/arm_description/b.stl", ""),
    ]);
    let beside = folder.paths("ws");
    let below = folder.paths("").with_roots([folder.0.join("ws")]);
    for paths in [beside.clone(), below.clone()] {
        for (name, place) in [("arm_description", "checkout"), ("old_arm", "arm_description")] {
            let found = paths.resolve(&format!("package://{name}/a.stl")).unwrap();
            assert_eq!(found, folder.0.join("ws").join(place).join("a.stl"));
        }
    }
    // What no package has is looked for as NAME/FILE beside the naming file.
    let found = beside.resolve("package://arm_description/b.stl").unwrap();
    assert_eq!(found, folder.0.join("ws/arm_description/b.stl"));
    assert_eq!(below.resolve("package://arm_description/b.stl").ok(), None);
}

#[test]
fn a_packages_name_is_decoded() {
    let folder = Folder::with(&[("my arm/a.stl", ""), ("given/a.stl", "")]);
    let name = "package://my%20ar%6d/a.stl";
    let beside = folder.paths("");
    assert_eq!(beside.resolve(name).unwrap(), folder.0.join("my arm/a.stl"));
    let given = beside.with_package("my arm", folder.0.join("given"));
    assert_eq!(given.resolve(name).unwrap(), folder.0.join("given/a.stl"));
}
