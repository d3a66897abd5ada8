//! Runs the program's `emit`.

mod common;

use common::{Run, Scratch, run};

const GAP: [&str; 7] = ["emit", "--nodes", "9", "--output", "gap", "--mode", "hessian"];

fn printed(arguments: &[&str]) -> String {
    let Run { code, stdout, stderr } = run(arguments);
    assert_eq!((code, stderr.as_str()), (0, ""));
    stdout
}

/// The numbers of the line of the comment that starts with `label`.
#[track_caller]
fn counts(source: &str, label: &str) -> Vec<usize> {
    let line = source.lines().find_map(|line| line.strip_prefix("// ")?.strip_prefix(label));
    line.expect("no such line").split_whitespace().map(|figure| figure.parse().unwrap()).collect()
}

#[test]
fn the_source_is_rust_and_says_its_operations() {
    let source = printed(&GAP);
    assert!(source.contains("use ::diffuse_contact_kernels::support::*;"));
    assert!(source.contains("pub fn gap_hessian<T: Lane>("));
    assert!(source.contains("pub fn gap_hessian_n9<T: Lane>("));
    assert!(syn::parse_file(&source).is_ok());

    let [element, iteration, node, pair, all] =
        ["per element", "per Newton iteration", "per node", "per pair of nodes", "9 nodes, 1 iteration"]
            .map(|label| counts(&source, label));
    for row in [&element, &iteration, &node, &pair, &all] {
        assert_eq!(row.len(), 8);
        assert_eq!(row[0], row[1..].iter().sum::<usize>());
    }
    assert_eq!(all[0], element[0] + iteration[0] + 9 * node[0] + 36 * pair[0]);
    assert!(all[0] <= 10_000, "{} operations", all[0]);
    assert!(source.contains(&format!("{} operations", all[0])));
}

#[test]
fn every_output_and_mode_of_either_basis_is_printed() {
    for basis in ["quadratic", "linear"] {
        for output in ["coefficients", "surface", "gap"] {
            for mode in ["value", "gradient", "hessian"] {
                let arguments =
                    ["emit", "--nodes", "6", "--output", output, "--mode", mode, "--basis", basis];
                let source = printed(&arguments);
                assert!(source.starts_with(&format!("// {output} {mode}, {basis} basis")), "{source}");
                assert!(source.contains(&format!("pub fn {output}_{mode}_n6<T: Lane>(")));
            }
        }
    }
}

#[test]
fn a_formula_of_ones_own_changes_the_kernel() {
    let formula = "exp(-r)*(1 + r)";
    let source = printed(&[&GAP[..], &["--weight", formula]].concat());
    assert!(source.contains(&format!("weight {formula}, frozen frame: operations")));
    assert!(source.contains(".exp()"));
    assert!(!printed(&GAP).contains(".exp()"));
    // The paper's weight is what no formula means.
    let cubic = printed(&[&GAP[..], &["--weight", "(1 - r)^2 * (1 + 2*r)"]].concat());
    assert_eq!(cubic, printed(&GAP));
}

#[test]
fn a_frame_that_moves_with_the_nodes_has_kernels_for_the_derivatives_of_the_gap() {
    let source = printed(&[&GAP[..], &["--frame-derivative", "co-moving"]].concat());
    assert!(source.contains("co-moving frame: operations"));
    assert!(counts(&source, "per node")[0] > counts(&printed(&GAP), "per node")[0]);
    run(&[
        "emit",
        "--nodes",
        "9",
        "--output",
        "surface",
        "--mode",
        "hessian",
        "--frame-derivative",
        "co-moving",
    ])
    .assert_refused(&["co-moving", "surface hessian"]);
}

#[test]
fn a_file_holds_the_same_text() {
    let scratch = Scratch::new("emit");
    let file = scratch.path("gap.rs");
    assert_eq!(printed(&[&GAP[..], &["-o", &file]].concat()), "");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), printed(&GAP));
    run(&[&GAP[..], &["-o", &scratch.path("none/gap.rs")]].concat())
        .assert_refused(&["there is no directory"]);
    assert_eq!(scratch.names(), ["gap.rs"]);
}

#[test]
fn the_counts_of_all_kernels_are_two_tables() {
    let table = printed(&["emit", "--counts"]);
    assert_eq!(table.lines().filter(|line| line.starts_with("| ")).count(), 2 + 24 + 2 + 2);
    let facets: Vec<&str> = table.lines().rev().take(2).collect();
    assert!(facets[1].starts_with("| triangle ") && facets[0].starts_with("| quadrilateral "), "{table}");
    let rows: Vec<&str> =
        table.lines().filter(|line| line.contains("| gap          | hessian  | frozen ")).collect();
    assert_eq!(rows.len(), 2);
    let totals: Vec<&str> = rows[0].split('|').map(str::trim).collect();
    assert_eq!(totals[1], "quadratic");
    assert_eq!(totals[6], counts(&printed(&GAP), "9 nodes, 1 iteration")[0].to_string());
    let linear = printed(&["emit", "--counts", "--basis", "linear"]);
    assert!(!linear.contains("quadratic"));
    assert!(linear.contains(rows[1]));
}

#[test]
fn a_bad_formula_is_pointed_at() {
    let Run { code, stdout, stderr } = run(&[&GAP[..], &["--weight", "(1 - r)^2 * (1 + 2*q)"]].concat());
    assert_eq!((code, stdout.as_str()), (2, ""));
    let lines: Vec<&str> = stderr.lines().collect();
    assert_eq!(lines.len(), 3, "{stderr}");
    assert!(lines[0].starts_with("error: --weight: in formula"), "{stderr}");
    assert!(lines[0].contains("character 20: `q` is unknown"), "{stderr}");
    assert_eq!(lines[2].find('^'), lines[1].find('q'));
    run(&[&GAP[..], &["--weight", "1 - r"]].concat()).assert_refused(&["--weight", "kink at r = 0"]);
    run(&[&GAP[..], &["--weight", "r^2 - 0.5"]].concat()).assert_refused(&["--weight", "positive"]);
}

#[test]
fn what_no_kernel_can_be_made_for_is_refused() {
    let refused = |nodes: &str, basis: &str, parts: &[&str]| {
        run(&["emit", "--nodes", nodes, "--output", "gap", "--mode", "value", "--basis", basis])
            .assert_refused(parts);
    };
    refused("5", "quadratic", &["--nodes 5", "quadratic", "at least 6"]);
    refused("2", "linear", &["--nodes 2", "linear", "at least 3"]);
    refused("65", "linear", &["--nodes", "at most 64"]);
    refused("nine", "linear", &["'nine'", "--nodes"]);
    refused("9", "cubic", &["'cubic'", "quadratic, linear"]);
    run(&["emit", "--nodes", "9", "--output", "gap"]).assert_refused(&["--mode"]);
    run(&["emit", "--counts", "--nodes", "9"]).assert_refused(&["--counts", "--nodes"]);
    run(&["emit", "--nodes", "9", "--output", "foot", "--mode", "value"])
        .assert_refused(&["'foot'", "coefficients, surface, gap"]);
}
