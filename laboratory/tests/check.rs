//! Runs the program's `check` on small ranges, and the library behind it.

use crate::runs::{Run, run};
use diffuse_contact_codegen::{Basis, FrameRule, Output};
use diffuse_contact_laboratory::check::blocks::blocks;
use diffuse_contact_laboratory::check::facets::FACET_BLOCKS;
use diffuse_contact_laboratory::check::{Plan, TOLERANCE, compare};
use diffuse_contact_laboratory::weight::Weight;
use serde_json::Value;

#[test]
fn a_small_range_passes_and_every_block_is_printed() {
    let Run { code, stdout, stderr } = run(&["check", "--nodes", "6..=7"]);
    assert_eq!((code, stderr.as_str()), (0, ""), "{stdout}");
    assert!(stdout.ends_with("\nall within 1e-12\n"), "{stdout}");
    let of_the_slip = "but of the slip the interpreter of their graph";
    assert_eq!(stdout.contains(of_the_slip), cfg!(not(feature = "friction")), "{stdout}");
    for block in blocks() {
        let row = stdout.lines().find(|line| {
            let rest = line.strip_prefix(&format!("{} ", block.subject.name()));
            rest.and_then(|rest| rest.split_whitespace().next()) == Some(block.name)
        });
        assert!(row.is_some(), "no row for {block:?} in {stdout}");
    }
    for shape in ["triangle", "quadrilateral"] {
        for block in FACET_BLOCKS {
            let start = format!("{shape:<16}{block:<10}");
            let row = stdout.lines().find(|line| line.starts_with(&start));
            assert!(row.is_some(), "no row {start:?} in {stdout}");
        }
    }
    for part in [
        "gap, co-moving  M",
        "against AD",
        "against interpreter",
        "between modes",
        "coefficients, surface, gap, slip\n",
        "quadratic 6",
        "n = 6 to 7",
        "12 in all",
        "cubic: (1 - r)^2 * (1 + 2*r)\n",
        "cubic-interpolating: omega/(1 - omega), omega = (1 - r)^2 * (1 + 2*r)\n",
        "wendland-c2: (1 - r)^4 * (1 + 4*r)\n",
    ] {
        assert!(stdout.contains(part), "{part:?} is not in {stdout}");
    }
}

#[test]
fn the_json_has_the_same_figures() {
    let arguments = ["check", "--nodes", "9", "--basis", "quadratic", "--seed", "5", "--json"];
    let Run { code, stdout, stderr } = run(&arguments);
    assert_eq!((code, stderr.as_str()), (0, ""));
    let document: Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!(document["passes"], true);
    assert_eq!(document["reports"].as_array().unwrap().len(), 3);
    let report = &document["reports"][1];
    assert_eq!(report["passes"], true);
    assert!(report["weight"].as_str().unwrap().starts_with("cubic-interpolating: "));
    assert_eq!((&report["seed"], &report["elements"]), (&Value::from(5), &Value::from(3)));
    let rows = report["blocks"].as_array().unwrap();
    assert_eq!((rows.len(), blocks().count()), (57, 57));
    for (block, row) in blocks().zip(rows) {
        assert_eq!(
            (row["output"].as_str(), row["block"].as_str()),
            (Some(block.subject.output.name()), Some(block.name))
        );
        let frame = match block.subject.frame {
            FrameRule::Held => "held",
            FrameRule::CoMoving => "co-moving",
            FrameRule::Material => "material",
        };
        assert_eq!(row["frame_derivative"], frame);
        // Without the feature the interpreter stands in for the kernels with a slip.
        let has_kernels = block.subject.output != Output::Slip || cfg!(feature = "friction");
        assert_eq!(row["tested"], if has_kernels { "generated" } else { "interpreter" }, "{row}");
        for against in if has_kernels { &["ad", "interpreter"][..] } else { &["ad"] } {
            let worst = &row["against"][against];
            let difference = worst["difference"].as_f64().unwrap();
            assert!(difference <= TOLERANCE, "{row}");
            assert_eq!((&worst["basis"], &worst["nodes"]), (&Value::from("quadratic"), &Value::from(9)));
        }
    }
    // Facets have no weight: they are compared once.
    assert_eq!(report["facets"].as_array().map(Vec::len), Some(0));
    let facets = document["reports"][0]["facets"].as_array().unwrap();
    assert_eq!(facets.len(), 2 * FACET_BLOCKS.len());
    for row in facets {
        assert_eq!(row["passes"], true, "{row}");
        assert!(row["against"]["interpreter"].as_f64().unwrap() <= TOLERANCE, "{row}");
    }
    for report in document["reports"].as_array().unwrap() {
        let balance = report["balance"].as_array().unwrap();
        assert_eq!(balance.len(), 5, "forces of three frames, moments of two");
        for row in balance {
            assert!(row["worst"]["difference"].as_f64().unwrap() <= 1e-13, "{row}");
        }
    }
    assert_eq!(stdout, run(&arguments).stdout, "the same seed gives the same bytes");
}

#[test]
fn ranges_are_cut_to_what_a_basis_can_use() {
    let only_linear = run(&["check", "--nodes", "4..6"]);
    assert_eq!(only_linear.code, 0);
    assert!(only_linear.stdout.contains(" linear basis n = 4 to 5; "), "{}", only_linear.stdout);
    assert!(!only_linear.stdout.contains("quadratic"));
    let both = run(&["check", "--nodes", "5..=6"]).stdout;
    assert!(both.contains("quadratic basis n = 6, linear basis n = 5 to 6"), "{both}");
}

#[test]
fn more_nodes_than_a_vector_has_lanes_pass_too() {
    let plan = Plan::default().nodes(Basis::Linear, 17..=17).nodes(Basis::Quadratic, 17..=17);
    let report = compare(&plan, || {}).unwrap();
    assert!(report.passes(), "{report}");
}

#[test]
fn a_weight_of_ones_own_passes() {
    let Run { code, stdout, stderr } = run(&["check", "--nodes", "6..=7", "--weight", "exp(-r) * (1 + r)"]);
    assert_eq!(code, 0, "{stdout}");
    // It ends at r = 1 with a jump.
    assert!(
        stderr.starts_with("note: the weight \"exp(-r) * (1 + r)\"") && stderr.lines().count() == 1,
        "{stderr}"
    );
    assert!(stdout.contains("no kernels of this weight are compiled into the program"), "{stdout}");
    assert!(stdout.contains("exp(-r) * (1 + r)"));
    assert!(!stdout.contains("against interpreter") && !stdout.contains("triangle"));
    assert!(stdout.ends_with("\nall within 1e-12\n"), "{stdout}");
}

#[test]
fn a_weight_made_interpolating_passes() {
    let arguments = ["check", "--nodes", "6..=8", "--weight", "(1 - r^2)^3", "--interpolating"];
    let Run { code, stdout, stderr } = run(&arguments);
    assert_eq!((code, stderr.as_str()), (0, ""), "{stdout}");
    assert!(stdout.contains("omega = (1 - r^2)^3\n"), "{stdout}");
    let named = run(&["check", "--nodes", "7", "--weight", "wendland-c2"]);
    assert_eq!(named.code, 0);
    assert!(
        named.stdout.contains("the generated kernels") && !named.stdout.contains("cubic"),
        "{}",
        named.stdout
    );
    run(&["check", "--weight", "2 - r^2", "--interpolating"])
        .assert_refused(&["--weight", "has to be 1 at r = 0"]);
    run(&["check", "--interpolating"]).assert_refused(&["--weight"]);
}

#[test]
fn polynomials_roots_and_branches_pass() {
    for formula in [
        "(1 - r)^4 * (1 + 4*r)",
        "sqrt(1 - r^2)^3",
        "if r < 0.5 { 2/3 - 4*r^2 + 4*r^3 } else { 4/3 - 4*r + 4*r^2 - 4/3*r^3 }",
    ] {
        let weight = Weight::new(formula, false).unwrap();
        let plan = Plan { weight, ..Plan::default() };
        let plan = plan.nodes(Basis::Linear, 5..=5).nodes(Basis::Quadratic, 9..=9);
        let report = compare(&plan, || {}).unwrap();
        assert!(report.passes(), "{report}");
    }
}

#[test]
fn what_cannot_be_checked_is_refused() {
    let refused = |arguments: &[&str], parts: &[&str]| {
        run(&[&["check"], arguments].concat()).assert_refused(parts);
    };
    refused(&["--nodes", "2..=7"], &["--nodes 2..=7", "linear", "at least 3"]);
    refused(&["--nodes", "5..=7", "--basis", "quadratic"], &["--nodes 5..=7", "quadratic", "at least 6"]);
    refused(&["--nodes", "9..=6"], &["'9..=6'", "--nodes", "empty"]);
    refused(&["--nodes", "6..6"], &["'6..6'", "empty"]);
    refused(&["--nodes", "six"], &["'six'", "6..=12"]);
    refused(&["--nodes", "6..=100000"], &["at most 500"]);
    refused(&["--seed", "one"], &["'one'", "--seed"]);
    refused(&["--weight", "1 - r"], &["--weight", "kink at r = 0"]);
    // So narrow that nodes have no weight to speak of.
    refused(&["--nodes", "6", "--weight", "exp(-600*r^2)"], &["6 master nodes", "well conditioned"]);
    let bad = run(&["check", "--weight", "1 - r^0.5"]);
    assert_eq!((bad.code, bad.stdout.as_str()), (2, ""));
    assert!(bad.stderr.contains("character 7: an exponent must be an integer"), "{}", bad.stderr);
}
