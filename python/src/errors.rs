//! Exceptions. Their classes are Python's (`package/diffuse_contact/_errors.py`); the codes are those of the Rust errors.

use diffuse_contact::ElementError;
use diffuse_contact::assembly::AssemblyError;
use diffuse_contact::interface::InterfaceError;
use diffuse_contact::surface::{SurfaceError, WindowError};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

static CLASSES: PyOnceLock<Py<PyModule>> = PyOnceLock::new();

/// An exception of `class`, a name in `diffuse_contact._errors`.
pub fn exception(py: Python<'_>, class: &str, code: &str, message: &str) -> PyErr {
    let classes = CLASSES.get_or_try_init(py, || py.import("diffuse_contact._errors").map(Bound::unbind));
    let made = classes.and_then(|module| module.bind(py).getattr(class)?.call1((message, code)));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// What was passed is not what the function takes.
pub fn input(py: Python<'_>, code: &str, message: &str) -> PyErr {
    exception(py, "InputError", code, message)
}

/// The object is in use by another thread.
pub fn busy(py: Python<'_>, what: &str) -> PyErr {
    let message = format!("{what} is in use by another thread: wait for it, or give each thread its own");
    exception(py, "BusyError", "busy", &message)
}

/// A Rust error as an exception.
pub trait Raise: std::fmt::Display {
    /// Name of the Python class.
    const CLASS: &'static str;

    /// Stable machine-readable code.
    fn stable_code(&self) -> &'static str;

    /// The exception.
    fn raise(&self, py: Python<'_>) -> PyErr {
        exception(py, Self::CLASS, self.stable_code(), &self.to_string())
    }
}

macro_rules! raises {
    ($error:ty, $class:literal) => {
        impl Raise for $error {
            const CLASS: &'static str = $class;

            fn stable_code(&self) -> &'static str {
                self.code()
            }
        }
    };
}

raises!(SurfaceError, "SurfaceError");
raises!(InterfaceError, "InterfaceError");
raises!(WindowError, "InterfaceError");
raises!(AssemblyError, "AssemblyError");
raises!(ElementError, "ElementError");
