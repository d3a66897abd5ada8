//! The jobs where the system gives less than they ask for.

use crate::runs::{Scratch, run_with_instructions, run_without_threads};

/// A shipped mesh.
const MESH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../mesh/meshes/plate_on_cylinder.msh");

/// Every job that writes outlives the limit, and leaves nothing half written.
#[cfg(unix)]
#[test]
fn a_limit_on_files_is_an_error_of_any_job_that_writes() {
    let scratch = Scratch::new("limited-jobs");
    let masters: Vec<[f64; 3]> = (0..81).map(|k| [f64::from(k % 9), f64::from(k / 9), 0.0]).collect();
    let search = serde_json::json!({"slave": [3.3, 3.4, 0.5], "masters": masters, "outward": [0, 0, 1]});
    let input = scratch.file("in.json", &serde_json::json!({"elements": [search]}).to_string());
    let searches = scratch.file("searches.json", &serde_json::json!(vec![search; 99]).to_string());
    let (json, vtu) = (scratch.path("out.json"), scratch.path("out.vtu"));
    for arguments in [
        format!("evaluate '{input}' -o '{json}'"),
        format!("neighbours '{searches}' -o '{json}'"),
        format!("surface '{MESH}' --slave slave --master master -o '{vtu}'"),
        format!("demo -o '{vtu}'"),
    ] {
        let full = crate::runs::run_limited(8, &arguments);
        assert_eq!(full.code, 2, "{arguments}: {full:?}");
        assert!(full.stderr.contains("cannot be written: "), "{arguments}: {full:?}");
        assert_eq!(scratch.names(), ["in.json", "searches.json"], "{arguments}");
    }
}

/// Where no thread can be started the calling one does the work.
#[cfg(target_os = "linux")]
#[test]
fn without_threads_one_does_the_work() {
    let scratch = Scratch::new("threadless");
    let output = scratch.path("out.vtu");
    for arguments in [&["demo", "-o", &output][..], &["surface", MESH, "-o", &output]] {
        let shown = run_without_threads(arguments);
        assert_eq!(shown.code, 0, "{shown:?}");
        assert!(shown.stderr.contains("note: no threads can be started"), "{shown:?}");
    }
}

#[test]
fn unknown_vector_instructions_are_refused() {
    run_with_instructions("nonsense", &["demo"]).assert_refused(&[
        "DIFFUSE_CONTACT_ISA",
        "\"nonsense\"",
        "scalar",
    ]);
}
