use super::super::MeshPlace;
use super::*;

/// One triangle with the corners 0, x, y, and beside it a point that it does not name.
const GEOMETRY: &str = r##"<geometry id="triangle"><mesh>
    <source id="points"><float_array id="numbers" count="12">0 0 0  1 0 0  0 1 0  9 9 9</float_array>
        <technique_common><accessor source="#numbers" count="4" stride="3">
            <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
        </accessor></technique_common></source>
    <vertices id="corners"><input semantic="POSITION" source="#points"/></vertices>
    <triangles count="1"><input semantic="VERTEX" source="#corners" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry>"##;

const SHOWN: &str = r##"<instance_geometry url="#triangle"/>"##;

/// A file with z up.
fn file(more: &str, nodes: &str) -> String {
    with_asset("<up_axis>Z_UP</up_axis>", more, nodes)
}

fn with_asset(asset: &str, more: &str, nodes: &str) -> String {
    format!(
        "<?xml version=\"1.0\"?>\n<COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" \
         version=\"1.4.1\">\n<asset>{asset}</asset>\n\
         <library_geometries>{GEOMETRY}</library_geometries>\n{more}\n\
         <library_visual_scenes><visual_scene id=\"shown\">\n{nodes}\n</visual_scene>\
         </library_visual_scenes>\n\
         <scene><instance_visual_scene url=\"#shown\"/></scene>\n</COLLADA>"
    )
}

#[test]
fn what_is_said_twice_or_stands_in_no_element_is_refused() {
    for asset in [
        "<unit meter=\"0.01\"/><unit meter=\"1\"/>",
        "<up_axis>Z_UP</up_axis><up_axis>Y_UP</up_axis>",
    ] {
        let refused = read_file(&with_asset(asset, "", "")).unwrap_err().to_string();
        assert!(refused.contains("a second <"), "{refused}");
    }
    let list = |counts: &str| {
        format!(
            "<polylist count=\"1\"><input semantic=\"VERTEX\" source=\"#corners\" offset=\"0\"/>{counts}<p>0 1 2</p></polylist>"
        )
    };
    assert!(with_primitives(&list("<vcount>3</vcount>")).is_ok());
    assert!(with_primitives(&list("<vcount>3</vcount><vcount>3</vcount>")).is_err());
    assert!(with_primitives(&list("<vcount>3</vcount>4 5 6")).is_err());
}

fn read_file(text: &str) -> Result<TriangleMesh, MeshError> {
    read(text.as_bytes(), UpAxis::Ros)
}

/// Where the triangle's corners are, for the nodes around it.
fn corners(nodes: &str) -> Vec<DVec3> {
    read_file(&file("", nodes)).unwrap().vertices
}

/// The file with another mesh in place of the triangle's, of the points 0 to 4 on a row of squares,
/// each (k / 2, k % 2, 0).
fn with_primitives(primitives: &str) -> Result<TriangleMesh, MeshError> {
    let start = file("", &format!("<node>{SHOWN}</node>"));
    let numbers = "0 0 0  0 1 0  1 0 0  1 1 0  2 0 0  2 1 0";
    let text = start
        .replace("count=\"12\">0 0 0  1 0 0  0 1 0  9 9 9", &format!("count=\"18\">{numbers}"))
        .replace("count=\"4\"", "count=\"6\"");
    let (before, rest) = text.split_once("<triangles").unwrap();
    let (_, after) = rest.split_once("</triangles>").unwrap();
    read_file(&[before, primitives, after].concat())
}

fn near(found: DVec3, expected: [f64; 3]) {
    assert!(found.distance(DVec3::from_array(expected)) < 1e-12, "{found} is not {expected:?}");
}

fn refusal(text: &str) -> (String, usize, String) {
    match read_file(text).unwrap_err() {
        MeshError::Refused { place: MeshPlace::Element { name, line }, problem, .. } => {
            (name, line, problem)
        }
        other => panic!("no element in: {other}"),
    }
}

#[test]
fn two_instances_of_a_geometry_are_two_triangles() {
    let instance = |x: i32| format!("<node><translate>{x} 0 0</translate>{SHOWN}</node>");
    let mesh = read_file(&file("", &(instance(3) + &instance(5)))).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(mesh.vertices[0], DVec3::new(3.0, 0.0, 0.0));
    assert_eq!(mesh.vertices[4], DVec3::new(6.0, 0.0, 0.0));
    // The point that no triangle names is no part of it.
    assert_eq!(mesh.vertices.len(), 6);
    let twice_in_a_node = read_file(&file("", &format!("<node>{SHOWN}{SHOWN}</node>"))).unwrap();
    assert_eq!(twice_in_a_node.triangles.len(), 2);
}

#[test]
fn nested_transforms_apply_in_the_order_of_the_document() {
    let nodes = format!(
        "<node><translate>10 0 0</translate><rotate>0 0 1 90</rotate>\
         <node><scale>2 3 4</scale><translate>1 0 0</translate>{SHOWN}</node></node>"
    );
    let [a, b, c] = corners(&nodes)[..] else { panic!() };
    // (0, 0, 0) to (1, 0, 0) to (2, 0, 0) to (0, 2, 0) to (10, 2, 0).
    near(a, [10.0, 2.0, 0.0]);
    near(b, [10.0, 4.0, 0.0]);
    near(c, [7.0, 2.0, 0.0]);
}

#[test]
fn a_matrix_is_read_row_by_row() {
    let nodes = format!("<node><matrix>0 -1 0 5 1 0 0 6 0 0 1 7 0 0 0 1</matrix>{SHOWN}</node>");
    let [a, b, c] = corners(&nodes)[..] else { panic!() };
    assert_eq!((a, b), (DVec3::new(5.0, 6.0, 7.0), DVec3::new(5.0, 7.0, 7.0)));
    assert_eq!(c, DVec3::new(4.0, 6.0, 7.0));
}

#[test]
fn a_turn_is_in_degrees_about_an_axis_of_any_length() {
    let nodes = format!("<node><rotate>0 0 7 30</rotate>{SHOWN}</node>");
    near(corners(&nodes)[1], [3f64.sqrt() / 2.0, 0.5, 0.0]);
    let nothing = format!("<node><rotate>0 0 0 0</rotate>{SHOWN}</node>");
    assert_eq!(corners(&nothing)[1], DVec3::X);
}

#[test]
fn a_skew_turns_its_first_axis_towards_its_second_by_the_angle() {
    // The example of the specification: y leans over to x by 45 degrees.
    let nodes = format!("<node><skew>45 0 1 0 1 0 0</skew>{SHOWN}</node>");
    let [a, b, c] = corners(&nodes)[..] else { panic!() };
    near(a, [0.0; 3]);
    near(b, [1.0, 0.0, 0.0]);
    near(c, [1.0, 1.0, 0.0]);
    // Axes that are not perpendicular, of any length: the angle of the image to the first is 30.
    let nodes = format!("<node><skew>30 0 2 0 3 3 0</skew>{SHOWN}</node>");
    let [_, b, c] = corners(&nodes)[..] else { panic!() };
    let moved = c - DVec3::Y;
    assert!((c.normalize().dot(DVec3::Y) - 3f64.sqrt() / 2.0).abs() < 1e-12, "{c}");
    near(DVec3::new(moved.x - moved.y, moved.z, 0.0), [0.0; 3]);
    // What lies along the second axis stays: b and c move by opposite amounts.
    near(b + c, [1.0, 1.0, 0.0]);
    for wrong in ["90 0 1 0 1 0 0", "10 1 0 0 1 0 0", "10 1 0 0 0 0 0"] {
        let (name, ..) = refusal(&file("", &format!("<node><skew>{wrong}</skew>{SHOWN}</node>")));
        assert_eq!(name, "skew");
    }
}

#[test]
fn a_look_at_stands_at_the_eye_and_looks_along_minus_z() {
    let nodes = format!("<node><lookat>1 2 3  5 2 3  0 0 1</lookat>{SHOWN}</node>");
    let [a, b, c] = corners(&nodes)[..] else { panic!() };
    near(a, [1.0, 2.0, 3.0]);
    // Looking along x with z up, right is −y.
    near(b, [1.0, 1.0, 3.0]);
    near(c, [1.0, 2.0, 4.0]);
}

#[test]
fn a_transform_that_mirrors_keeps_the_front() {
    let nodes = format!("<node><scale>1 -1 1</scale>{SHOWN}</node>");
    assert_eq!(read_file(&file("", &nodes)).unwrap().triangles, [[0, 2, 1]]);
}

#[test]
fn nodes_of_the_library_are_shown_where_they_are_instantiated() {
    let library = format!(
        "<library_nodes><node id=\"part\"><translate>0 0 1</translate>{SHOWN}</node>\
         <node id=\"other\">{SHOWN}</node></library_nodes>"
    );
    let nodes = "<node><translate>1 0 0</translate><instance_node url=\"#part\"/></node>\n\
                 <node><translate>2 0 0</translate><instance_node url=\"#part\"/></node>";
    let mesh = read_file(&file(&library, nodes)).unwrap();
    assert_eq!(mesh.triangles.len(), 2);
    assert_eq!(mesh.vertices[0], DVec3::new(1.0, 0.0, 1.0));
    assert_eq!(mesh.vertices[3], DVec3::new(2.0, 0.0, 1.0));
}

#[test]
fn inches_become_metres_after_all_transforms() {
    let asset = "<unit name=\"inch\" meter=\"0.0254\"/><up_axis>Z_UP</up_axis>";
    let nodes = format!("<node><translate>100 0 0</translate>{SHOWN}</node>");
    let mesh = read_file(&with_asset(asset, "", &nodes)).unwrap();
    near(mesh.vertices[1], [2.5654, 0.0, 0.0]);
    assert!(mesh.warnings.is_empty());
    for wrong in ["0", "-1", "nan", "one"] {
        let (name, line, _) = refusal(&with_asset(&format!("\n<unit meter=\"{wrong}\"/>"), "", ""));
        assert_eq!((name.as_str(), line), ("unit", 4));
    }
}

#[test]
fn the_up_axis_counts_only_on_request() {
    // The triangle's corner on y.
    for (axis, named, turned) in [
        ("<up_axis>Y_UP</up_axis>", "Y_UP", [0.0, 0.0, 1.0]),
        ("", "Y_UP", [0.0, 0.0, 1.0]),
        ("<up_axis>X_UP</up_axis>", "X_UP", [-1.0, 0.0, 0.0]),
    ] {
        let text = with_asset(axis, "", &format!("<node>{SHOWN}</node>"));
        for (up_axis, expected) in [(UpAxis::Ros, [0.0, 1.0, 0.0]), (UpAxis::File, turned)] {
            let mesh = read(text.as_bytes(), up_axis).unwrap();
            assert_eq!(mesh.vertices[2], DVec3::from_array(expected), "{axis}");
            assert_eq!(mesh.triangles, [[0, 1, 2]], "a turn does not mirror");
            assert_eq!(mesh.warnings, [MeshWarning::UpAxis { axis: named, taken: up_axis }]);
        }
    }
    let z_up = file("", &format!("<node>{SHOWN}</node>"));
    let both = [UpAxis::Ros, UpAxis::File].map(|up_axis| read(z_up.as_bytes(), up_axis).unwrap());
    assert_eq!(both[0], both[1]);
    assert!(both[0].warnings.is_empty());
}

#[test]
fn polygons_strips_and_fans_become_triangles() {
    let input = "<input semantic=\"VERTEX\" source=\"#corners\" offset=\"0\"/>";
    let points = |mesh: TriangleMesh| -> Vec<[[f64; 2]; 3]> {
        let at = |k: u32| mesh.vertices[k as usize];
        mesh.triangles.iter().map(|t| t.map(|k| [at(k).x, at(k).y])).collect()
    };
    let [a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5].map(|k| [f64::from(k / 2), f64::from(k % 2)]);
    for (primitives, expected) in [
        (
            format!(
                "<polylist count=\"2\">{input}<vcount>4 3</vcount><p>0 2 3 1  2 4 5</p></polylist>"
            ),
            vec![[a, c, d], [a, d, b], [c, e, f]],
        ),
        (
            format!("<polygons count=\"2\">{input}<p>0 2 3 1</p><p>2 4 5</p></polygons>"),
            vec![[a, c, d], [a, d, b], [c, e, f]],
        ),
        (
            format!("<tristrips count=\"2\">{input}<p>0 2 1 3 5</p><p>4 5 3</p></tristrips>"),
            vec![[a, c, b], [b, c, d], [b, d, f], [e, f, d]],
        ),
        (
            format!("<trifans count=\"1\">{input}<p>0 2 4 5</p></trifans>"),
            vec![[a, c, e], [a, e, f]],
        ),
    ] {
        assert_eq!(points(with_primitives(&primitives).unwrap()), expected, "{primitives}");
    }
}

#[test]
fn several_inputs_with_offsets_of_their_own_are_distinguished() {
    let inputs = "<input semantic=\"NORMAL\" source=\"#nothing\" offset=\"0\"/>\
                  <input semantic=\"VERTEX\" source=\"#corners\" offset=\"2\"/>\
                  <input semantic=\"TEXCOORD\" source=\"#nothing\" offset=\"3\" set=\"1\"/>";
    let list = "9 9 5 9  9 9 4 9  9 9 3 9";
    let mesh =
        with_primitives(&format!("<triangles count=\"1\">{inputs}<p>{list}</p></triangles>"));
    let mesh = mesh.unwrap();
    let corners = mesh.triangles[0].map(|k| mesh.vertices[k as usize]);
    assert_eq!(corners, [[2.0, 1.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1.0, 0.0]].map(DVec3::from_array));
}

#[test]
fn an_accessor_picks_its_numbers_by_name_offset_and_stride() {
    let text = file("", &format!("<node>{SHOWN}</node>"))
        .replace(
            "count=\"12\">0 0 0  1 0 0  0 1 0  9 9 9",
            "count=\"15\">7 7 <!-- z, nothing, y, x --> 3 0 2 1 6 0 5 4 9 0 8 7 0",
        )
        .replace("count=\"4\" stride=\"3\"", "offset=\"2\" count=\"3\" stride=\"4\"")
        .replace("<param name=\"X\" type=\"float\"/>", "<param name=\"Z\"/><param type=\"float\"/>")
        .replace("<param name=\"Z\" type=\"float\"/>", "<param name=\"X\"/>");
    let mesh = read_file(&text).unwrap();
    assert_eq!(mesh.vertices[0], DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(mesh.vertices[2], DVec3::new(7.0, 8.0, 9.0));
}

#[test]
fn lines_are_passed_over_with_a_warning() {
    let input = "<input semantic=\"VERTEX\" source=\"#corners\" offset=\"0\"/>";
    let mesh = with_primitives(&format!(
        "<lines count=\"1\">{input}<p>0 1</p></lines>\
         <polylist count=\"2\">{input}<vcount>2 3</vcount><p>0 1 2 4 5</p></polylist>"
    ));
    let mesh = mesh.unwrap();
    assert_eq!(mesh.triangles.len(), 1);
    assert_eq!(mesh.warnings, [MeshWarning::Lines { count: 2 }]);
}

#[test]
fn what_could_hide_geometry_is_refused_with_element_and_line() {
    let mesh = |inside: &str| {
        file("", &format!("<node>{SHOWN}</node>")).replace(
            "<geometry id=\"triangle\"><mesh>",
            &format!("<geometry id=\"triangle\">\n{inside}"),
        )
    };
    let node = |inside: &str| file("", &format!("<node>\n{inside}</node>"));
    let triangles =
        |inside: &str| file("", &format!("<node>{SHOWN}</node>")).replace("<p>0 1 2</p>", inside);
    for (text, element) in [
        (node("<instance_controller url=\"#skin\"/>"), "instance_controller"),
        (node("<instance_geometry url=\"other.dae#triangle\"/>"), "instance_geometry"),
        (node("<instance_node url=\"http://x/y.dae#n\"/>"), "instance_node"),
        (node("<instance_geometry url=\"#gone\"/>"), "instance_geometry"),
        (node("<instance_novelty/>"), "instance_novelty"),
        (mesh("<convex_mesh convex_hull_of=\"#x\"/><mesh>"), "convex_mesh"),
        (mesh("<spline/><mesh>"), "spline"),
        (mesh("<mesh><novelty/>"), "novelty"),
        (triangles("\n<ph><p>0 1 2</p><h>0 1 2</h></ph>"), "ph"),
        (node("<asset><unit meter=\"0.1\"/></asset>"), "asset"),
        (node("<matrix>1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1</matrix>"), "matrix"),
    ] {
        let (name, line, problem) = refusal(&text);
        let before = &text[..text.rfind(&format!("<{element}")).unwrap()];
        let expected = before.matches('\n').count() + 1;
        assert_eq!((name.as_str(), line), (element, expected), "{problem}");
    }
    let unseen = file("", "").replace("<scene><instance_visual_scene url=\"#shown\"/></scene>", "");
    assert!(refusal(&unseen).2.contains("no visual scene"));
    let outside = file("", "").replace("\"#shown\"", "\"other.dae#shown\"");
    assert_eq!(refusal(&outside).0, "instance_visual_scene");
}

#[test]
fn two_elements_of_an_id_are_distinguished_or_refused() {
    let again = format!("<library_geometries>{GEOMETRY}</library_geometries>");
    let text = file(&again, &format!("<node>{SHOWN}</node>"));
    assert!(refusal(&text).2.contains("several"));
    // Another geometry may use the ids of its sources again.
    let other = again.replace("\"triangle\"", "\"other\"").replace("1 0 0  0 1 0", "8 0 0  0 8 0");
    let nodes = format!("<node>{SHOWN}<instance_geometry url=\"#other\"/></node>");
    let mesh = read_file(&file(&other, &nodes)).unwrap();
    assert_eq!((mesh.vertices[1].x, mesh.vertices[4].x), (1.0, 8.0));
}

#[test]
fn counts_that_do_not_hold_are_refused_before_anything_is_allocated() {
    let good = file("", &format!("<node>{SHOWN}</node>"));
    for (from, to, element) in [
        ("count=\"12\"", "count=\"13\"", "float_array"),
        ("count=\"12\"", "count=\"99999999999999999999\"", "float_array"),
        ("0 1 0  9", "0 one 0  9", "float_array"),
        ("0 1 0  9", "0 NaN 0  9", "float_array"),
        ("0 1 0  9", "0 1e999 0  9", "float_array"),
        ("count=\"4\"", "count=\"5\"", "accessor"),
        ("count=\"4\"", "count=\"18446744073709551615\"", "accessor"),
        ("stride=\"3\"", "stride=\"18446744073709551615\"", "accessor"),
        ("stride=\"3\"", "stride=\"0\"", "accessor"),
        ("stride=\"3\"", "stride=\"3\" offset=\"1\"", "accessor"),
        ("name=\"Z\"", "name=\"W\"", "accessor"),
        ("<p>0 1 2", "<p>0 1 4", "p"),
        ("<p>0 1 2", "<p>0 1 -1", "p"),
        ("<p>0 1 2", "<p>0 1", "p"),
        ("<triangles count=\"1\"", "<triangles count=\"2\"", "triangles"),
        ("offset=\"0\"", "offset=\"18446744073709551615\"", "input"),
        ("offset=\"0\"", "offset=\"1\"", "p"),
        ("offset=\"0\"", "", "input"),
        ("source=\"#points\"", "source=\"#gone\"", "input"),
        ("\"VERTEX\"", "\"NORMAL\"", "triangles"),
    ] {
        let changed = good.replacen(from, to, 1);
        assert_ne!(changed, good, "{from}");
        let (name, ..) = refusal(&changed);
        assert_eq!(name.split(' ').next(), Some(element), "{to}");
    }
}

#[test]
fn a_polylist_and_its_counts_must_fit() {
    let input = "<input semantic=\"VERTEX\" source=\"#corners\" offset=\"0\"/>";
    for sizes in ["3", "3 4", "4294967295", ""] {
        let primitives =
            format!("<polylist>{input}<vcount>{sizes}</vcount><p>0 1 2 3 4 5</p></polylist>");
        let error = with_primitives(&primitives).unwrap_err().to_string();
        assert!(error.contains("<vcount>"), "{error}");
    }
}

#[test]
fn nodes_without_end_are_refused() {
    let library =
        "<library_nodes><node id=\"n\"><instance_node url=\"#n\"/></node></library_nodes>";
    let (name, _, problem) = refusal(&file(library, "<node><instance_node url=\"#n\"/></node>"));
    assert!(name.starts_with("node") && problem.contains("nested"), "{problem}");
    // Each shows the next one twice.
    let twice = |k: u32| {
        let next = format!("<instance_node url=\"#n{}\"/>", k + 1);
        format!("<node id=\"n{k}\">{next}{next}</node>")
    };
    let doubling: String = (0..40).map(twice).collect();
    let library =
        format!("<library_nodes>{doubling}<node id=\"n40\">{SHOWN}</node></library_nodes>");
    let (_, _, problem) = refusal(&file(&library, "<node><instance_node url=\"#n0\"/></node>"));
    assert!(problem.contains("more than"), "{problem}");
    let deep = "<node>".repeat(5_000) + &"</node>".repeat(5_000);
    assert!(refusal(&file("", &deep)).2.contains("nested"));
}

#[test]
fn instances_cannot_multiply_triangles_without_bound() {
    let input = "<input semantic=\"VERTEX\" source=\"#corners\" offset=\"0\"/>";
    let list = "0 1 2 ".repeat(20_000);
    let big = format!("<triangles>{input}<p>{list}</p></triangles>");
    let text = file("", &format!("<node>{}</node>", SHOWN.repeat(1_000)));
    let (before, rest) = text.split_once("<triangles").unwrap();
    let (_, after) = rest.split_once("</triangles>").unwrap();
    let (name, ..) = refusal(&[before, &big, after].concat());
    assert_eq!(name, "instance_geometry");
}

#[test]
fn a_file_that_is_cut_anywhere_is_refused() {
    let text = file("", &format!("<node>{SHOWN}</node>"));
    for end in 0..text.len() {
        assert!(read_file(&text[..end]).is_err(), "{end}");
    }
    let error = read_file(&text[..text.len() - 3]).unwrap_err();
    assert!(matches!(error, MeshError::Refused { place: MeshPlace::Line(_), .. }), "{error}");
}

#[test]
fn entities_of_a_document_type_are_refused() {
    let text = file("", "").replacen("?>\n", "?>\n<!DOCTYPE COLLADA [<!ENTITY a \"b\">]>\n", 1);
    assert!(read_file(&text).is_err());
}

#[test]
fn attributes_without_end_are_refused_with_their_line() {
    let text = |count: usize| {
        let attributes: String = (0..count).map(|k| format!(" a{k}=\"\"")).collect();
        file("", &format!("<node{attributes}>{SHOWN}</node>"))
    };
    assert!(read_file(&text(64)).is_ok());
    let error = read_file(&text(65)).unwrap_err().to_string();
    assert_eq!(error, "COLLADA, line 14: more than 64 attributes of an element");
    let declared = format!("<extra>{}</extra>", "<a xmlns=\"u\"/>".repeat(1024));
    let error = read_file(&file(&declared, "")).unwrap_err().to_string();
    assert!(error.contains("more than 1024 namespace declarations"), "{error}");
}

#[test]
fn animations_are_named_and_not_played() {
    let moved = "<animation><channel source=\"#s\" target=\"n/t\"/></animation>";
    let library =
        format!("<library_animations><animation>{moved}{moved}</animation></library_animations>");
    let node = format!("<node>{SHOWN}</node>");
    let mesh = read_file(&file(&library, &node)).unwrap();
    assert_eq!(mesh.warnings, [MeshWarning::Animations { count: 2 }]);
    let still = read_file(&file("<library_animations/>", &node)).unwrap();
    assert_eq!((still.warnings, still.vertices), (vec![], mesh.vertices));
}
