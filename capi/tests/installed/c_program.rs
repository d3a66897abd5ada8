//! The C example against the Rust crate, bit for bit, and under valgrind.

use std::process::Command;

use crate::support::{Installed, assert_same, c_compiler, from_hexadecimal, has, records, root, run};
use runtime::assembly::{ContactLaw, CsrPattern, DofMap, Tangent, add_forces};
use runtime::interface::{ContactInterface, InterfaceOptions};
use runtime::surface::{Facet, MasterSurface};
use runtime::{Backend, Element, Frame, Generated, Mode};

const MASTERS: usize = 81;
const SLAVES: usize = 25;

/// Compiles the example with the flags of pkg-config, statically or not.
fn compile(installed: &Installed, name: &str, libraries: &[String]) {
    compile_source(installed, name, "capi/examples/press.c", libraries);
}

fn compile_source(installed: &Installed, name: &str, source: &str, libraries: &[String]) {
    let mut command = Command::new(c_compiler());
    command.args(["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1", "-o"]);
    command.arg(installed.prefix.join(name)).arg(root().join(source));
    run(command.args(installed.flags(&["--cflags"])).args(libraries).arg("-lm"));
}

#[test]
fn the_measurement_of_overhead_runs() {
    if !has("pkg-config") {
        return;
    }
    let installed = Installed::new("c-overhead");
    compile_source(&installed, "overhead", "capi/examples/overhead.c", &installed.flags(&["--libs"]));
    let printed = run(installed.program("overhead").args(["2", "3"]));
    let rows: Vec<Vec<f64>> = printed
        .lines()
        .skip(2)
        .map(|line| line.split_whitespace().map(|word| word.parse().expect("a number")).collect())
        .collect();
    assert_eq!(rows.iter().map(|row| row[0]).collect::<Vec<_>>(), [8.0, 12.0, 16.0, 20.0], "{printed}");
    assert!(rows.iter().all(|row| row.len() == 4 && row[1..].iter().all(|time| *time > 0.0)), "{printed}");
}

#[test]
fn a_forked_process_evaluates_in_threads_of_its_own() {
    if !has("pkg-config") {
        return;
    }
    let installed = Installed::new("c-fork");
    compile_source(&installed, "forking", "capi/tests/programs/fork.c", &installed.flags(&["--libs"]));
    // Two at least, or there is nobody to wait for.
    let mut command = Command::new("timeout");
    command.arg("60").arg(installed.prefix.join("forking"));
    command.env("LD_LIBRARY_PATH", installed.prefix.join("lib")).env("RAYON_NUM_THREADS", "3");
    assert_eq!(run(&mut command).trim(), "the child agrees on 484 gaps and at all points of 441 faces");
}

#[test]
fn the_c_example_prints_the_numbers_of_rust() {
    if !has("pkg-config") {
        return;
    }
    let installed = Installed::new("c-program");
    compile(&installed, "press", &installed.flags(&["--libs"]));
    let printed = run(installed.program("press").arg("--bits"));
    replay(&printed);

    let archive = installed.prefix.join("lib/libdiffuse_contact.a").display().to_string();
    let others = installed.flags(&["--libs", "--static"]).into_iter();
    let libraries: Vec<String> =
        [archive].into_iter().chain(others.filter(|flag| flag != "-ldiffuse_contact")).collect();
    compile(&installed, "press-static", &libraries);
    let printed_static = run(Command::new(installed.prefix.join("press-static")).arg("--bits"));
    assert_eq!(printed, printed_static);
}

/// Stacks that no address space has room for keep threads from starting, as a limit on processes does.
#[test]
fn a_program_without_threads_has_the_same_numbers() {
    if !has("pkg-config") {
        return;
    }
    let installed = Installed::new("c-threadless");
    compile(&installed, "press", &installed.flags(&["--libs"]));
    let printed =
        run(installed.program("press").arg("--bits").env("RUST_MIN_STACK", (1_usize << 60).to_string()));
    assert_eq!(printed, run(installed.program("press").arg("--bits")));
}

/// Both libraries, from a prefix that was moved.
#[test]
fn cmake_finds_the_library() {
    if !has("cmake") {
        return;
    }
    let installed = Installed::new("c-cmake");
    let project = installed.prefix.join("project");
    let moved = installed.prefix.with_file_name("c-cmake-moved");
    let _ = std::fs::remove_dir_all(&moved);
    std::fs::create_dir_all(&project).unwrap();
    let lists = "cmake_minimum_required(VERSION 3.10)\nproject(press C)\nset(CMAKE_C_STANDARD 11)\n\
                 find_package(diffuse_contact 0.1 REQUIRED)\n\
                 foreach(kind diffuse_contact static)\n  add_executable(press_${kind} ${SOURCE})\n\
                 \x20 target_link_libraries(press_${kind} PRIVATE diffuse_contact::${kind} m)\nendforeach()\n";
    std::fs::write(project.join("CMakeLists.txt"), lists).unwrap();
    std::fs::rename(&installed.prefix, &moved).unwrap();
    let build = moved.join("build");
    let mut configure = Command::new("cmake");
    configure.arg("-S").arg(moved.join("project")).arg("-B").arg(&build);
    configure.arg(format!("-DCMAKE_PREFIX_PATH={}", moved.display()));
    run(configure.arg(format!("-DSOURCE={}", root().join("capi/examples/press.c").display())));
    run(Command::new("cmake").arg("--build").arg(&build));
    let printed = run(Command::new(build.join("press_diffuse_contact")).arg("--bits"));
    replay(&printed);
    assert_eq!(printed, run(Command::new(build.join("press_static")).arg("--bits")));
}

#[test]
fn the_c_example_leaks_nothing() {
    if !(has("pkg-config") && has("valgrind")) {
        return;
    }
    let installed = Installed::new("c-valgrind");
    compile(&installed, "press", &installed.flags(&["--libs"]));
    let mut command = Command::new("valgrind");
    command.args([
        "--error-exitcode=3",
        "--leak-check=full",
        "--errors-for-leak-kinds=definite,indirect,possible",
    ]);
    command.arg(format!("--suppressions={}", root().join("capi/tests/valgrind.supp").display()));
    // Not every valgrind knows every vector instruction.
    command.env("DIFFUSE_CONTACT_ISA", "scalar").env("LD_LIBRARY_PATH", installed.prefix.join("lib"));
    let printed = run(command.arg(installed.prefix.join("press")));
    assert!(printed.contains("increment 4: 25 paired"), "{printed}");
}

/// Does with the Rust crate what the example did, at the positions it printed.
fn replay(printed: &str) {
    let law = ContactLaw::penalty(2.0e3);
    let equation = |node: usize, axis| (node >= MASTERS).then(|| 3 * (node - MASTERS) + axis);
    let rows = (0..MASTERS + SLAVES).map(|node| [0, 1, 2].map(|axis| equation(node, axis)));
    let dofs = DofMap::new(3 * SLAVES, rows).unwrap();
    let mut interface: Option<ContactInterface> = None;
    let (mut refreshes, mut evaluations, mut others) = (0, 0, 0);
    let mut one = None;
    for (name, values) in records(printed, from_hexadecimal) {
        let positions = || values.as_chunks::<3>().0;
        match name.as_str() {
            "refresh" => {
                let interface = interface.get_or_insert_with(|| new_interface(positions()));
                interface.refresh_pairing(positions()).unwrap();
                refreshes += 1;
            }
            "positions" => {
                let interface = interface.as_mut().unwrap();
                interface.update(positions()).unwrap();
                interface.evaluate(Mode::Hessian).unwrap();
                evaluations += 1;
            }
            "gaps" | "residual" | "tangent" | "tangent-far" | "pressures" => {
                let contacts = interface.as_ref().unwrap().contacts();
                let expected = match name.as_str() {
                    "gaps" => contacts.iter().map(|contact| contact.point.gap).collect(),
                    "residual" => {
                        let mut residual = vec![0.0; dofs.equations()];
                        add_forces(contacts, &law, &dofs, &mut residual).unwrap();
                        residual
                    }
                    "tangent" | "tangent-far" => {
                        let tangent = if name == "tangent" { Tangent::Exact } else { Tangent::GaussNewton };
                        let law = law.with_tangent(tangent);
                        let pattern = CsrPattern::union(contacts, &dofs).unwrap();
                        let mut tangent = vec![0.0; pattern.entries()];
                        pattern.fill(contacts, &law, &mut tangent).unwrap();
                        tangent
                    }
                    _ => contacts
                        .iter()
                        .enumerate()
                        .map(|(k, contact)| law.force(k, contact.point.gap, contact.area) / contact.area)
                        .collect(),
                };
                assert_same(&name, &values, &expected);
                others += 1;
            }
            "one" | "one-gradient" | "one-hessian" => {
                let gap = one.get_or_insert_with(one_element);
                let expected = match name.as_str() {
                    "one" => &[gap.gap],
                    "one-gradient" => gap.gradient.as_slice(),
                    _ => gap.hessian.packed(),
                };
                assert_same(&name, &values, expected);
                others += 1;
            }
            other => panic!("{other} is no record"),
        }
    }
    assert_eq!(refreshes, 4);
    assert!(evaluations >= 8);
    assert!(printed.contains("\ntangent ") && printed.contains("\ntangent-far "), "both tangents occur");
    assert_eq!(others, 3 * evaluations + 4 + 3);
}

fn new_interface(positions: &[[f64; 3]]) -> ContactInterface {
    let quadrilateral = |[a, b, c, d]: [usize; 4]| Facet::Quadrilateral([a, b, c, d]);
    let corners = (0..64).map(|k| k % 8 + 9 * (k / 8)).map(|k| [k, k + 1, k + 10, k + 9]);
    let master = MasterSurface::new(positions, corners.map(quadrilateral).collect()).unwrap();
    let slave_corners = (0..16).map(|k| MASTERS + k % 4 + 5 * (k / 4)).map(|k| [k, k + 5, k + 6, k + 1]);
    let slave_facets: Vec<Facet> = slave_corners.map(quadrilateral).collect();
    let slaves = (MASTERS..MASTERS + SLAVES).collect();
    let options = InterfaceOptions::default().with_areas(true);
    ContactInterface::new(master, slaves, &slave_facets, positions, options).unwrap()
}

fn one_element() -> runtime::Gap {
    let masters: Vec<[f64; 3]> = (0..9)
        .map(|k| [f64::from(k % 3) - 1.0, f64::from(k / 3) - 1.0, 0.01 * f64::from(k) * f64::from(k)])
        .collect();
    let element = Element::new(
        [0.1, 0.2, 0.25],
        &masters,
        Frame::average_plane(&masters, [0.0, 0.0, 1.0]).unwrap(),
        2.0,
    );
    Generated.gap(&element, Mode::Hessian).unwrap()
}
