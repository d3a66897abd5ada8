//! The report of a refresh as a dictionary.

use diffuse_contact::interface::{GapJump, RefreshReport, SlaveGap};
use pyo3::prelude::*;
use pyo3::types::PyDict;

pub fn to_dict<'py>(py: Python<'py>, report: &RefreshReport) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, count) in [
        ("paired", report.paired),
        ("kept", report.kept),
        ("renewed", report.renewed),
        ("changed", report.changed),
        ("gained", report.gained),
        ("lost", report.lost),
        ("deep", report.deep),
        ("contacts_lost", report.contacts_lost),
        ("contacts_gained", report.contacts_gained),
    ] {
        dict.set_item(name, count)?;
    }
    dict.set_item("without", report.without.clone())?;
    let fallbacks = PyDict::new(py);
    fallbacks.set_item("none", report.fallbacks.none)?;
    fallbacks.set_item("extended", report.fallbacks.extended)?;
    fallbacks.set_item("linear", report.fallbacks.linear)?;
    dict.set_item("fallbacks", fallbacks)?;
    let slave_gap = |gap: Option<SlaveGap>| gap.map(|SlaveGap { slave, gap }| (slave, gap));
    dict.set_item("smallest_gap_lost", slave_gap(report.smallest_gap_lost))?;
    dict.set_item("smallest_gap_gained", slave_gap(report.smallest_gap_gained))?;
    let jump = report.largest_gap_jump.map(|GapJump { slave, before, after }| (slave, before, after));
    dict.set_item("largest_gap_jump", jump)?;
    dict.set_item("rebuilt", report.rebuilt)?;
    Ok(dict)
}
