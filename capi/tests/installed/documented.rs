//! The programs of the how-to pages for C and Fortran do what these say.

use std::path::Path;
use std::process::Command;

use crate::support::{Installed, c_compiler, has, root, run};

/// A code block of the language's page, counted from 0, and the one that follows: what it prints.
fn block(language: &str, number: usize) -> (String, String) {
    let page = std::fs::read_to_string(root().join(format!("docs/how-to/{language}.md"))).expect("the page");
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
        let source = installed.prefix.join("program.c");
        written(&source, &program);
        let mut command = Command::new(c_compiler());
        command
            .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-o"])
            .arg(installed.prefix.join("program"))
            .arg(&source);
        run(command.args(installed.flags(&["--cflags", "--libs"])).arg("-lm"));
        assert_eq!(run(&mut installed.program("program")), prints);
    }
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
