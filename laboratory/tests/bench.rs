//! The `bench` job.

use crate::runs::run;
use diffuse_contact_kernels::support::Isa;
use serde_json::Value;

#[test]
fn json_has_a_row_for_every_contender() {
    let run = run(&["bench", "--json", "--nodes", "6,7", "--rounds", "1", "--elements", "4"]);
    assert_eq!((run.code, run.stderr.as_str()), (0, ""));
    let report: Value = serde_json::from_str(&run.stdout).unwrap();
    assert!(report["peak_fma_per_ns"].as_f64().unwrap() > 0.0);
    assert_eq!(report["isa"], Isa::best().name());
    let rows = report["rows"].as_array().unwrap();
    for row in rows {
        assert!(row["ns_per_element"].as_f64().unwrap() > 0.0, "{row}");
        let counted = row["kernel"].as_str().unwrap().starts_with("generated");
        assert_eq!(row["fma_per_element"].is_number(), counted, "{row}");
        assert_eq!(row["fraction_of_peak"].is_number(), counted, "{row}");
    }
    let absent = report["absent"].as_array().unwrap();
    assert!(absent.iter().all(|x| x["nodes"] == 7 && x["kernel"] == "num-dual-dual2-vec"), "{absent:?}");
    assert_eq!(rows.len() % 2, 1, "one contender is compiled for 6 nodes only");
    // The gap's Hessian at 6 nodes: the generator's count and two to four more evaluations of the foot equations.
    let full = rows
        .iter()
        .find(|row| row["kernel"] == "generated-single" && row["output"] == "gap-hessian")
        .unwrap();
    let operations = full["fma_per_element"].as_f64().unwrap();
    assert!(operations > 5_533.0 && operations < 5_900.0, "{operations}");
}

#[test]
fn any_vector_instructions_of_the_machine_can_be_chosen() {
    let arguments = ["bench", "--nodes", "6", "--rounds", "1", "--elements", "3", "--kernels", "generated"];
    for isa in Isa::available() {
        let run = run(&[&arguments[..], &["--json", "--isa", isa.name()]].concat());
        assert_eq!((run.code, run.stderr.as_str()), (0, ""));
        let report: Value = serde_json::from_str(&run.stdout).unwrap();
        assert_eq!(report["isa"], isa.name());
        let names: Vec<&str> =
            report["rows"].as_array().unwrap().iter().map(|row| row["kernel"].as_str().unwrap()).collect();
        assert_eq!(names.iter().filter(|name| **name == "generated-batch").count(), 3, "{names:?}");
        assert_eq!(names.iter().filter(|name| **name == "generated-single").count(), 4, "{names:?}");
    }
}

#[test]
fn a_table_names_the_kernels_asked_for() {
    let run = run(&["bench", "--nodes", "6", "--rounds", "1", "--elements", "2", "--kernels", "by-hand"]);
    assert_eq!(run.code, 0);
    assert!(run.stdout.contains("by-hand-nalgebra") && !run.stdout.contains("generated-single"));
}

#[test]
fn what_cannot_be_measured_is_one_sentence() {
    for (arguments, sentence) in [
        (["--nodes", "5"], "5 master nodes: the quadratic basis needs at least 6"),
        (["--kernels", "fortran"], "no kernel has a name with fortran; there are generated-single, "),
        (["--rounds", "0"], "invalid value '0' for '--rounds <K>'"),
        (["--isa", "mmx"], "invalid value 'mmx' for '--isa <NAME>': this machine has scalar, "),
        (["--nodes", "8,x"], "invalid value 'x' for '--nodes <N,N,...>'"),
    ] {
        run(&[&["bench"], &arguments[..]].concat()).assert_refused(&[sentence]);
    }
}
