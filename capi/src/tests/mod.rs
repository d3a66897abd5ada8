//! Calls as C makes them; and the header and the Fortran module beside the sources.

mod agreement;
mod cutback;
mod defaults;
mod domains;
mod faces;
mod faces_points;
mod faces_window;
mod feet;
mod fortran_module;
mod friction;
mod fuzz;
mod header;
mod laws;
mod memory;
mod misuse;
mod part;
mod random;
mod tangent;
mod window;

use std::ffi::{CStr, c_char};
use std::ptr::null;

use runtime::interface::{ContactInterface, InterfaceOptions};
use runtime::surface::{Facet, MasterSurface};

use crate::interface::{dc_create, dc_interface};
use crate::options::{dc_options, dc_options_default};
use crate::status::{DC_OK, dc_message, dc_status};

/// What the library says about the last failure of this thread.
fn message() -> String {
    text(dc_message())
}

fn text(pointer: *const c_char) -> String {
    // SAFETY: a text of the library.
    unsafe { CStr::from_ptr(pointer) }.to_str().expect("ASCII").to_owned()
}

/// The default options.
fn options() -> dc_options {
    let mut options = dc_options { size: size_of::<dc_options>(), ..dc_options::defaults() };
    options.border_tolerance = f64::NAN;
    // SAFETY: a whole structure.
    assert_eq!(unsafe { dc_options_default(&mut options) }, DC_OK);
    options
}

/// A ridge of 6 × 6 nodes below four slave nodes.
#[derive(Clone)]
struct Mesh {
    positions: Vec<f64>,
    facets: Vec<i32>,
    slaves: Vec<i32>,
    slave_facets: Vec<i32>,
}

impl Mesh {
    fn new() -> Self {
        let mut positions = Vec::new();
        for k in 0..36 {
            let (x, y) = (f64::from(k % 6), f64::from(k / 6));
            positions.extend([x, y, -0.04 * (x - 2.5) * (x - 2.5)]);
        }
        for [x, y] in [[2.1, 2.2], [2.2, 3.1], [3.2, 3.3], [3.1, 2.1]] {
            positions.extend([x, y, -0.05]);
        }
        let corners = (0..25).map(|k| k % 5 + 6 * (k / 5));
        let facets = corners.flat_map(|k| [k, k + 1, k + 7, k + 6]).collect();
        Self { positions, facets, slaves: vec![36, 37, 38, 39], slave_facets: vec![36, 37, 38, 39] }
    }

    fn nodes(&self) -> usize {
        self.positions.len() / 3
    }

    fn points(&self) -> &[[f64; 3]] {
        self.positions.as_chunks::<3>().0
    }

    /// The same interface by the runtime.
    fn of_runtime(&self, options: InterfaceOptions) -> ContactInterface {
        let quadrilateral = |row: &[i32; 4]| Facet::Quadrilateral(row.map(|node| node as usize));
        let facets = |corners: &[i32]| corners.as_chunks::<4>().0.iter().map(quadrilateral).collect();
        let master = MasterSurface::new(self.points(), facets(&self.facets)).unwrap();
        let slaves = self.slaves.iter().map(|&node| node as usize).collect();
        let slave_facets: Vec<Facet> = facets(&self.slave_facets);
        ContactInterface::new(master, slaves, &slave_facets, self.points(), options).unwrap()
    }

    /// The status of making an interface, and its handle.
    fn make(&self, options: *const dc_options) -> (dc_status, *mut dc_interface) {
        let mut handle = std::ptr::dangling_mut();
        // SAFETY: NULL, or a whole structure.
        let has_areas = unsafe { options.as_ref() }.is_some_and(|options| options.areas != 0);
        // SAFETY: the arrays have the lengths given.
        let status = unsafe {
            dc_create(
                self.positions.as_ptr(),
                self.nodes(),
                self.facets.as_ptr(),
                self.facets.len() / 4,
                self.slaves.as_ptr(),
                self.slaves.len(),
                self.slave_facets.as_ptr(),
                if has_areas { self.slave_facets.len() / 4 } else { 0 },
                options,
                &mut handle,
            )
        };
        assert_eq!(status == DC_OK, !handle.is_null(), "a handle comes with DC_OK alone");
        (status, handle)
    }

    /// An interface with the default options.
    fn interface(&self) -> *mut dc_interface {
        let (status, handle) = self.make(null());
        assert_eq!(status, DC_OK, "{}", message());
        handle
    }
}
