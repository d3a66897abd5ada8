//! The Abaqus user element, driven as Abaqus does, against the Rust crate, bit for bit.

use std::fmt::Write as _;
use std::path::PathBuf;
use std::process::Command;

use crate::support::{Installed, assert_same, from_bits, groups, has, records, root, run};
use runtime::assembly::{ContactLaw, ContactView};
use runtime::neighbourhood::{NeighbourSearch, SearchOptions};
use runtime::pairing::NearestNodes;
use runtime::{Basis, Element, Frame, Generated, Mode, Point};

const PENALTY: f64 = 3e3;

#[test]
fn the_user_element_has_the_numbers_of_rust() {
    if !(has("pkg-config") && has("gfortran")) {
        return;
    }
    let installed = Installed::new("fortran");
    build(&installed, "drive_uel");
    // It checks tangent, cut-backs and flags itself.
    let printed = run(installed.program("drive_uel").arg("--bits"));
    for said in [
        "flags are honoured",
        "properties are honoured",
        "a lost surface asks for a cut-back",
        "a divergent iteration asks for a cut-back",
        "few candidates carry the linear basis",
        "structures fit",
        "the adaptive tangent switches",
    ] {
        assert!(printed.contains(said), "{said}: {printed}");
    }
    refuse_mistakes(&installed);

    // PROPS(9), the regularity that a fit has to exceed.
    let regular = run(installed.program("drive_uel").args(["--bits", "0.35"]));
    let regular_search = SearchOptions::default().with_smallest_regularity(0.35);
    assert_ne!(regular, printed);
    for (printed, search) in [(printed, SearchOptions::default()), (regular, regular_search)] {
        let calls = groups(records(&printed, from_bits), "now");
        assert!(calls.len() >= 12, "{} calls", calls.len());
        let mut active = 0;
        for call in &calls {
            let [now, start] = ["now", "start"].map(|name| call[name].as_chunks::<3>().0);
            let (rhs, amatrx) = user_element(now, start, &call["history"], search);
            assert_same("rhs", &call["rhs"], &rhs);
            assert_same("amatrx", &call["amatrx"], &amatrx);
            active += usize::from(rhs.iter().any(|force| *force != 0.0));
        }
        assert!(active > calls.len() / 2);
    }
}

/// Compiles a driver of this name with the user element.
fn build(installed: &Installed, driver: &str) {
    let user_element = installed.prefix.join("share/diffuse_contact/uel.f90");
    compile(installed, driver, &[user_element, root().join("fortran").join(driver).with_extension("f90")]);
}

fn compile(installed: &Installed, name: &str, sources: &[PathBuf]) {
    let mut command = Command::new("gfortran");
    // Comparisons of numbers are meant, and so are dummy arguments that Abaqus passes and nobody needs.
    command.args([
        "-std=f2018",
        "-Wall",
        "-Wextra",
        "-Werror",
        "-Wno-compare-reals",
        "-Wno-unused-dummy-argument",
    ]);
    command.args(["-Wno-surprising", "-fcheck=all", "-O1", "-J"]);
    command.arg(&installed.prefix).arg("-o").arg(installed.prefix.join(name)).args(sources);
    run(command.args(installed.flags(&["--libs"])));
}

/// The driver compares each force and stiffness with an interface of the whole surface, bit for bit.
#[test]
fn the_user_element_with_facets_has_the_numbers_of_the_whole_surface() {
    if !(has("pkg-config") && has("gfortran")) {
        return;
    }
    let installed = Installed::new("fortran-domains");
    build(&installed, "drive_uel_domains");
    let printed = run(&mut installed.program("drive_uel_domains"));
    let is_built_in = !printed.contains("friction is not built in");
    assert_eq!(is_built_in, printed.contains("with friction: "), "{printed}");
    assert_eq!(is_built_in, printed.contains("a coefficient of zero is no friction"), "{printed}");
    for said in [
        "without friction: ",
        "tangents against central differences",
        "all facets give what a window gives",
        "perturbations are linear",
        "a slave beyond its window asks for a cut-back",
        "a divergent iteration asks for a cut-back",
    ] {
        assert!(printed.contains(said), "{said}: {printed}");
    }
    refuse_mistakes_with_facets(&installed, is_built_in);
}

#[test]
fn a_slave_in_a_thin_plate_stays_on_the_side_that_it_came_from() {
    if !(has("pkg-config") && has("gfortran")) {
        return;
    }
    let installed = Installed::new("fortran-plate");
    build(&installed, "drive_uel_plate");
    let printed = run(&mut installed.program("drive_uel_plate"));
    assert!(printed.contains("from above: ") && printed.contains("from below: "), "{printed}");
}

fn refuse_mistakes_with_facets(installed: &Installed, is_built_in: bool) {
    let facets = "JPROPS of facets whose corners are nodes 2 to NNODE, or of a window";
    let history = "SVARS that it has written itself, or zeros";
    let says = [
        "VARIABLES of at least 12 with facets",
        "VARIABLES of at least 3 times the number of nodes and 11 with friction",
        facets,
        facets,
        facets,
        "PROPS(9) of 0",
        "PROPS(10:13), where there are such, that are finite and not negative",
        history,
        history,
        "foreign-carrier",
        "invalid-window",
        "its nodes are not those of its window, in the order of that",
        "has left what its window holds",
        "weight",
        "facets in JPROPS for friction",
        "no-friction-kernels",
        "JPROPS are no window",
    ];
    for (mistake, expected) in (1..).zip(says) {
        // It is none where friction is built in.
        if mistake == 16 && is_built_in {
            continue;
        }
        let output = installed.program("drive_uel_domains").args(["--refuse", &mistake.to_string()]).output();
        let output = output.expect("the driver");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(
            output.status.code(),
            Some(2),
            "mistake {mistake}: {said}{}",
            String::from_utf8_lossy(&output.stdout)
        );
        assert!(
            said.contains("diffuse contact: element 1") && said.contains(expected),
            "mistake {mistake}: {said}"
        );
    }
}

/// The input file is read, checked and run by a driver; with a mistake in it, it is not.
#[test]
fn the_example_input_is_consistent_and_runs() {
    if !(has("pkg-config") && has("gfortran")) {
        return;
    }
    let installed = Installed::new("fortran-input");
    build(&installed, "drive_input");
    let example = installed.prefix.join("share/diffuse_contact/examples/block_on_cylinder.inp");
    let printed = run(installed.program("drive_input").arg(&example));
    assert!(printed.contains("90 nodes, 8 bricks, 9 user elements of 36 nodes"), "{printed}");
    assert!(printed.contains("0 cut-backs, 3 pairings renewed"), "{printed}");
    // Each line of a slave ends with gap, force and number of masters.
    let number = |line: &str, name: &str| -> f64 {
        let (_, from) = line.split_once(name).unwrap_or_else(|| panic!("{name}: {line}"));
        let word = from.trim_start().split([' ', ',', ':']).next().expect("a number");
        word.parse().unwrap_or_else(|error| panic!("{line}: {error}"))
    };
    let slaves: Vec<&str> = printed.lines().filter(|line| line.starts_with("slave")).collect();
    assert_eq!(slaves.len(), 9);
    let areas = |label: f64| match label as i32 {
        105 => 0.81,
        102 | 104 | 106 | 108 => 0.405,
        _ => 0.2025,
    };
    let mut sum = 0.0;
    for line in slaves {
        let (label, gap, force) = (number(line, "slave"), number(line, "gap"), number(line, "force"));
        let expected = -2e4 * areas(label) * gap;
        assert!((force / expected - 1.0).abs() < 1e-11, "{line}");
        sum += force;
    }
    // Normals lean by 4.3 degrees at most.
    let held = printed.lines().find_map(|line| line.strip_prefix("force on the block")).expect("a force");
    let vertical: f64 = held.split_whitespace().nth(2).expect("z").parse().expect("a number");
    assert!(vertical < sum && vertical > 0.997 * sum, "{vertical} {sum}");
    refuse_mistakes_of_input(&installed, &std::fs::read_to_string(&example).expect("the example"));
}

/// With friction, facets in the file; and with the windows that write_uel writes: the same numbers.
#[test]
fn the_example_with_friction_runs_with_facets_and_with_windows() {
    if !(has("pkg-config") && has("gfortran")) {
        return;
    }
    let installed = Installed::new("fortran-friction-input");
    build(&installed, "drive_input");
    let share = installed.prefix.join("share/diffuse_contact");
    compile(&installed, "write_uel", &[share.join("write_uel.f90")]);
    let sound =
        std::fs::read_to_string(share.join("examples/block_on_cylinder_friction.inp")).expect("the example");
    let with_windows = with_windows(&installed, &sound);
    let run_file = |text: &str| {
        let path = installed.prefix.join("input.inp");
        std::fs::write(&path, text).expect("a file");
        installed.program("drive_input").arg(&path).output().expect("the driver")
    };
    let output = run_file(&sound);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if said.contains("no-friction-kernels") && output.status.code() == Some(2) {
        return;
    }
    let printed = String::from_utf8(output.stdout).expect("text");
    assert!(output.status.success(), "{printed}{said}");
    let slaves: Vec<&str> = printed.lines().filter(|line| line.starts_with("slave")).collect();
    assert_eq!(slaves.len(), 9);
    for line in slaves {
        let (gap, force) = line.split_once(", force").expect("a force");
        let gap: f64 = gap.split_once("gap").expect("a gap").1.trim().parse().expect("a number");
        let (force, friction) = force.split_once(", slip, friction").unwrap_or_else(|| panic!("{line}"));
        let force: f64 = force.trim().parse().expect("a number");
        let friction = friction.split_whitespace().map(|word| word.parse::<f64>().expect("a number").powi(2));
        // A slave below the surface moves less than its foot, by the depth over the radius of the cylinder.
        let expected = 1.0 - gap / 20.0;
        assert!((friction.sum::<f64>().sqrt() / (0.3 * force) - expected).abs() < 1e-5, "{line}");
    }
    // In another order of elements the sum of all forces has other last digits.
    let windows = run_file(&with_windows);
    let windows_printed = String::from_utf8(windows.stdout).expect("text");
    assert!(windows.status.success(), "{windows_printed}{}", String::from_utf8_lossy(&windows.stderr));
    let by_slave = |text: &str| {
        let mut lines: Vec<String> =
            text.lines().filter(|line| line.starts_with("slave")).map(str::to_owned).collect();
        lines.sort();
        lines
    };
    assert_eq!(by_slave(&windows_printed), by_slave(&printed));
    for (one, other, says) in [
        (", UNSYMM", "", "friction needs UNSYMM"),
        ("I PROPERTIES=193", "I PROPERTIES=192", "not PROPERTIES values"),
    ] {
        assert_eq!(sound.matches(one).count(), 1, "{one:?}");
        let output = run_file(&sound.replace(one, other));
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{one} → {other}: {said}");
        assert!(said.contains(says), "{one} → {other}: {said}");
    }
}

/// The example with what write_uel writes in the place of its user elements.
fn with_windows(installed: &Installed, example: &str) -> String {
    let rows = |keyword: &str| -> Vec<&str> {
        let (_, after) = example.split_once(keyword).expect("the keyword");
        after.lines().skip(1).take_while(|line| !line.starts_with('*')).collect()
    };
    let mut surfaces = format!(
        "*NODE\n{}\n{}\n*FACET\n",
        rows("*NODE, NSET=CYLINDER").join("\n"),
        rows("*NODE, NSET=BLOCK").join("\n")
    );
    for (row, column) in (0..6).flat_map(|row| (0..8).map(move |column| (row, column))) {
        let first = 9 * row + column + 1;
        writeln!(surfaces, "{first}, {}, {}, {}", first + 1, first + 10, first + 9).expect("a string");
    }
    surfaces.push_str("** slaves and areas\n*SLAVE\n");
    for (label, area) in (101..).zip([0.2025, 0.405, 0.2025, 0.405, 0.81, 0.405, 0.2025, 0.405, 0.2025]) {
        writeln!(surfaces, "{label}, {area}").expect("a string");
    }
    surfaces.push_str("*BOX\n0.9, 0.5, 0.5\n*PROPERTY\n20000., 0., 0.3, 0., 0., 0.3\n*FIRST\n1001\n");
    let path = installed.prefix.join("surfaces.txt");
    std::fs::write(&path, &surfaces).expect("a file");
    let written = run(installed.program("write_uel").arg(&path));
    let long = format!("0.9, 0.5, {}0.5", " ".repeat(256));
    for (one, other, says) in [
        ("0.9, 0.5, 0.5", "0.9, 0.5 7, 0.5", "not a number: line "),
        ("0.9, 0.5, 0.5", "0.9, 0.5/7, 0.5", "not a number: line "),
        ("0.9, 0.5, 0.5", &long, "256 characters or more: line "),
        ("\n104, 0.405", "\n104.4, 0.405", "a label is not a whole number: line "),
        ("*FACET\n", "*NODE\n105, 0., 0., 0.\n*FACET\n", "a second node has the label 105"),
    ] {
        assert_eq!(surfaces.matches(one).count(), 1, "{one:?}");
        std::fs::write(&path, surfaces.replace(one, other)).expect("a file");
        let output = installed.program("write_uel").arg(&path).output().expect("write_uel");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{one} → {other}: {said}");
        assert!(said.contains(says), "{one} → {other}: {said}");
    }
    let (before, _) = example.split_once("*USER ELEMENT").expect("user elements");
    let (_, after) = example.split_once("*ELSET, ELSET=CONTACT").expect("a set");
    format!("{before}{written}*ELSET, ELSET=CONTACT{after}")
}

fn refuse_mistakes_of_input(installed: &Installed, sound: &str) {
    let wrong = installed.prefix.join("wrong.inp");
    for (one, other, code, says) in [
        ("VARIABLES=47", "VARIABLES=46", 1, "VARIABLES of at least the number of nodes and 11"),
        ("NODES=36", "NODES=35", 1, "not NODES nodes: user element 1001"),
        ("COORDINATES=3", "COORDINATES=2", 1, "COORDINATES=3"),
        ("PROPERTIES=9", "PROPERTIES=8", 1, "not PROPERTIES values: *UEL PROPERTY 1"),
        ("ELSET=MIDDLE\n20000.", "ELSET=CENTRE\n20000.", 1, "no *UEL PROPERTY: user element 1005"),
        ("\n1, 2, 3\n", "\n1, 2\n", 1, "three degrees of freedom"),
        ("\n1001, 101, ", "\n1001, 1, ", 1, "the first node belongs to no brick: user element 1001"),
        ("\n1009, 109, ", "\n1009, 101, ", 1, "those of another one: user element 1009"),
        ("\n1005, 105, 11, ", "\n1005, 105, 12, ", 1, "a node is named twice: user element 1005"),
        ("\n1005, 105, 11, ", "\n1005, 105, 104, ", 1, "a candidate belongs to the block: user element 1005"),
        ("\n1005, 105, 11, ", "\n1005, 105, 99, ", 1, "there is no node 99"),
        ("\n1005, 105, 11, ", "\n1005, 105, 1, 11, ", 1, "more than 16 entries"),
        ("*USER ELEMENT, TYPE=U1", "*USER ELEMENT, TYPE=U2", 1, "the user element is not U1"),
        // What the user element itself finds.
        ("20000., 0.81", "0., 0.81", 2, "diffuse contact: element 1005 needs a positive penalty PROPS(1)"),
        ("0.81, 0., 0., 0., 1.,", "0.81, 0., 1., 0., 0.,", 2, "ambiguous-outward"),
    ] {
        assert_eq!(sound.matches(one).count(), 1, "{one:?}");
        std::fs::write(&wrong, sound.replace(one, other)).expect("a file");
        let output = installed.program("drive_input").arg(&wrong).output().expect("the driver");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{one} → {other}: {said}");
        assert!(said.contains(says), "{one} → {other}: {said}");
    }
}

/// Each wrong input ends the analysis, with a sentence in the message file.
fn refuse_mistakes(installed: &Installed) {
    let says = [
        "at least 4 nodes of 3 displacements each",
        "COORDINATES=3",
        "PROPERTIES=8",
        "VARIABLES of at least the number of nodes and 11",
        "a positive penalty PROPS(1)",
        "PROPS(3) 0, 1 or 2",
        "a procedure without inertia",
        "LFLAGS(3) of 1, 2, 3, 4, 5 or 100",
    ];
    let history = "SVARS that it has written itself, or zeros";
    for mistake in 1..=24 {
        let output = installed.program("drive_uel").args(["--refuse", &mistake.to_string()]).output();
        let output = output.expect("the driver");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "mistake {mistake}: {said}");
        let expected = match mistake {
            1..=8 => says[mistake - 1],
            9..=18 => history,
            19 => "non-finite",
            20 | 21 => "a direction PROPS(4:6), finite and not zero",
            22 => "ambiguous-outward",
            _ => "PROPS(9), where there is one, of at least 0 and below 1",
        };
        assert!(
            said.contains("diffuse contact: element 1") && said.contains(expected),
            "mistake {mistake}: {said}"
        );
    }
}

/// What the user element is to return: force and stiffness over the coordinates of all its nodes.
fn user_element(
    now: &[Point],
    start: &[Point],
    history: &[f64],
    search: SearchOptions,
) -> (Vec<f64>, Vec<f64>) {
    let freedoms = 3 * now.len();
    let (mut rhs, mut amatrx) = (vec![0.0; freedoms], vec![0.0; freedoms * freedoms]);
    let is_paired = history[0] == 1.0;
    let (masters, support_radius, basis, outward): (Vec<usize>, f64, Basis, Point) = if is_paired {
        let masters = history[12..12 + history[1] as usize].iter().map(|&master| master as usize).collect();
        let basis = if history[3] == 1.0 { Basis::Linear } else { Basis::Quadratic };
        (masters, history[2], basis, [history[4], history[5], history[6]])
    } else {
        let outward = if history[0] == 0.0 { [0.0, 0.0, 1.0] } else { [history[4], history[5], history[6]] };
        let cloud = NearestNodes::new(start[1..].to_vec()).unwrap();
        let mut search = NeighbourSearch::new(search).unwrap();
        let found = search.find(&cloud, start[0], outward).unwrap();
        assert!(found.encloses_slave);
        let mut masters: Vec<usize> = found.nodes.iter().map(|node| node + 1).collect();
        masters.sort_unstable();
        (masters, found.support_radius, found.basis, found.frame.normal)
    };
    let positions: Vec<Point> = masters.iter().map(|&master| now[master]).collect();
    let element =
        Element::new(now[0], &positions, Frame::average_plane(&positions, outward).unwrap(), support_radius)
            .with_basis(basis);
    let own = element.degrees_of_freedom();
    let (mut gradient, mut hessian) = (vec![0.0; own], vec![0.0; own * (own + 1) / 2]);
    let point = Generated.gap_into(&element, Mode::Hessian, &mut gradient, &mut hessian).unwrap();
    let contact =
        ContactView { gap: point.gap, area: 1.0, gradient: &gradient, hessian: &hessian, slip: None };
    let (mut residual, mut tangent) = (vec![0.0; own], vec![0.0; own * own]);
    ContactLaw::penalty(PENALTY).element_system(&contact, &mut residual, &mut tangent).unwrap();
    let nodes = std::iter::once(0).chain(masters);
    let places: Vec<usize> = nodes.flat_map(|node| [3 * node, 3 * node + 1, 3 * node + 2]).collect();
    for (p, &row) in places.iter().enumerate() {
        rhs[row] = residual[p];
        for (q, &column) in places.iter().enumerate() {
            amatrx[row * freedoms + column] = tangent[p * own + q];
        }
    }
    (rhs, amatrx)
}
