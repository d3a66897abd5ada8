//! The programs of the how-to pages for C and Fortran do what these say.

use std::path::Path;
use std::process::Command;

use crate::support::{Installed, c_compiler, has, root, run};

fn page(name: &str) -> String {
    std::fs::read_to_string(root().join(format!("docs/how-to/{name}.md"))).expect("the page")
}

/// A code block of the language's page, counted from 0, and the one that follows: what it prints.
fn block(language: &str, number: usize) -> (String, String) {
    let page = page(language);
    let after = |text: &str, fence: &str| {
        let start = text.find(fence).unwrap_or_else(|| panic!("a block {fence}")) + fence.len();
        text[start..].to_owned()
    };
    let end = |text: &str| text[..text.find("```").expect("the end of a block")].to_owned();
    let fence = format!("```{language}\n");
    let rest = (0..=number).fold(page, |rest, _| after(&rest, &fence));
    let program = end(&rest);
    (program, end(&after(&rest, "```text\n")))
}

fn written(path: &Path, text: &str) {
    std::fs::write(path, text).expect("a file");
}

#[test]
fn the_c_programs_print_what_the_page_says() {
    if !has("pkg-config") {
        return;
    }
    let installed = Installed::new("documented-c");
    // A node on a spring; contact over faces.
    for number in [0, 1] {
        let (program, prints) = block("c", number);
        assert_eq!(run_c(&installed, &program), prints);
    }
}

/// What a program in C prints.
fn run_c(installed: &Installed, program: &str) -> String {
    let source = installed.prefix.join("program.c");
    written(&source, program);
    let mut command = Command::new(c_compiler());
    command
        .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-o"])
        .arg(installed.prefix.join("program"))
        .arg(&source);
    run(command.args(installed.flags(&["--cflags", "--libs"])).arg("-lm"));
    run(&mut installed.program("program"))
}

/// A slave 0.05 below a plane, with the laws of the page for friction.
const LAWS: &str = r#"
#include <stdio.h>
#include <stdlib.h>

static void check(enum dc_status status) {
    if (status != DC_OK) {
        fprintf(stderr, "%s\n", dc_message());
        exit(1);
    }
}

int main(void) {
    double positions[15] = {0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0, 1, 1, -0.05}, stiffness = 400;
    int32_t facet[4] = {0, 1, 2, 3}, slave = 4;
    dc_options options = {.size = sizeof options};
    check(dc_options_default(&options));
    options.element = DC_NODE_TO_FACET;
    dc_interface *interface;
    check(dc_create(positions, 5, facet, 1, &slave, 1, NULL, 0, &options, &interface));
    dc_law laws[2] = {law_by_tables(), law_of_functions(&stiffness)};
    for (int k = 0; k < 2; ++k) {
        double force[15] = {0};
        positions[12] = 1;
        check(dc_refresh(interface, positions, 5, NULL));
        check(dc_accept(interface, &laws[k], NULL, NULL, NULL, NULL, NULL));
        positions[12] = 1.5;
        check(dc_refresh(interface, positions, 5, NULL));
        check(dc_evaluate(interface, DC_HESSIAN));
        check(dc_add_forces(interface, &laws[k], force, 15, NULL));
        printf("%.6f %.6f\n", force[14], force[12] / force[14]);
    }
    check(dc_destroy(interface));
    return 0;
}
"#;

/// Fragments, which are functions.
#[test]
fn the_laws_of_the_page_for_friction_are_taken() {
    if !has("pkg-config") {
        return;
    }
    let installed = Installed::new("documented-laws");
    let page = page("friction");
    let fragments: Vec<&str> = page
        .split("```c\n")
        .skip(1)
        .map(|rest| rest.split("```").next().expect("the end of a block"))
        .collect();
    assert_eq!(fragments.len(), 2);
    let program = format!("#include <diffuse_contact.h>\n{}{LAWS}", fragments.concat());
    // By table 1 + 500 (0.05 - 0.02), and the coefficient of fast sliding; by the functions 400 0.05^2 and 0.3/1.01.
    assert_eq!(run_c(&installed, &program), "16.000000 -0.200000\n1.000000 -0.297030\n");
}

#[test]
fn the_header_is_good_for_cpp() {
    if !(has("pkg-config") && has("c++")) {
        return;
    }
    let installed = Installed::new("documented-cpp");
    let source = installed.prefix.join("program.cpp");
    let program = "#include <diffuse_contact.h>\n#include <iostream>\n\
        int main() { std::cout << dc_version() << std::endl; return dc_destroy(nullptr); }\n";
    written(&source, program);
    let mut command = Command::new("c++");
    command
        .args(["-std=c++11", "-Wall", "-Wextra", "-Werror", "-o"])
        .arg(installed.prefix.join("program"))
        .arg(&source);
    run(command.args(installed.flags(&["--cflags", "--libs"])));
    assert_eq!(run(&mut installed.program("program")).trim(), env!("CARGO_PKG_VERSION"));
}

#[test]
fn the_fortran_program_prints_what_the_page_says() {
    if !(has("pkg-config") && has("gfortran")) {
        return;
    }
    let installed = Installed::new("documented-fortran");
    let (program, prints) = block("fortran", 0);
    let source = installed.prefix.join("program.f90");
    written(&source, &program);
    let mut command = Command::new("gfortran");
    command.args(["-Wall", "-Wextra", "-Werror", "-fcheck=all", "-J"]).arg(&installed.prefix);
    command.arg("-o").arg(installed.prefix.join("program"));
    command.arg(installed.prefix.join("share/diffuse_contact/diffuse_contact.f90")).arg(&source);
    run(command.args(installed.flags(&["--libs"])));
    assert_eq!(run(&mut installed.program("program")), prints);
}
