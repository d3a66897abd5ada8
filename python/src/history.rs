//! The history of friction, of [`Interface`](crate::interface::Interface) and [`Faces`](crate::faces::Faces) alike.

use numpy::PyArray1;
use pyo3::prelude::*;

use crate::arrays::{Numbers, readable, slice};
use crate::errors;
use crate::faces::Faces;
use crate::interface::{Interface, exclusive, shared};
use crate::law::Law;
use crate::threads;

/// The methods of one class; macros cannot stand among methods, and methods of Python cannot be generic.
macro_rules! has_history {
    ($class:ty) => {
        #[pymethods]
        impl $class {
            /// Accepts the present positions as the end of an increment: slaves that stick, that slide, that carry force
            /// without a history, and that have lost their contact, and the work of friction.
            fn accept(slf: &Bound<'_, Self>, law: Law<'_>) -> PyResult<(usize, usize, usize, usize, f64)> {
                let py = slf.py();
                let mut this = exclusive(slf)?;
                let own = law.own(py)?;
                let law = own.law(py)?;
                let interface = &mut this.interface;
                let report = threads::attempt(py, || interface.accept(&law))?;
                this.current &= !this.interface.has_history();
                Ok((report.stuck, report.sliding, report.unanchored, report.dropped, report.dissipated))
            }

            /// A round of Uzawa's iteration for friction. `moves`: which slaves take part, or all.
            fn augment(
                slf: &Bound<'_, Self>,
                law: Law<'_>,
                moves: Option<&Bound<'_, PyArray1<bool>>>,
            ) -> PyResult<()> {
                let py = slf.py();
                let mut this = exclusive(slf)?;
                let own = law.own(py)?;
                let law = own.law(py)?;
                let moves = moves.map(readable).transpose()?;
                let moves = moves.as_ref().map(|moves| slice(py, moves)).transpose()?;
                let count = this.interface.slaves().len();
                if let Some(found) = moves.map(<[bool]>::len).filter(|found| *found != count) {
                    let message = format!("moves: {found} entries for {count} slaves");
                    return Err(errors::input(py, "wrong-shape", &message));
                }
                let interface = &mut this.interface;
                let moves = |slave: usize| moves.is_none_or(|moves| moves[slave]);
                threads::attempt(py, || interface.augment(&law, moves))?;
                this.current &= law.friction.is_none();
                Ok(())
            }

            /// How far each slave is from Coulomb's law without ε_T.
            fn slip_errors<'py>(slf: &Bound<'py, Self>, law: Law<'py>) -> PyResult<Numbers<'py>> {
                let py = slf.py();
                let this = shared(slf)?;
                let own = law.own(py)?;
                let law = own.law(py)?;
                let interface = &this.interface;
                let errors = threads::attempt(py, || interface.slip_errors(&law))?;
                Ok(PyArray1::from_vec(py, errors))
            }

            /// Forgets the rounds since the last accepted step.
            fn roll_back(slf: &Bound<'_, Self>) -> PyResult<()> {
                let mut this = exclusive(slf)?;
                this.interface.roll_back();
                this.current = false;
                Ok(())
            }

            /// The history of friction as plain numbers.
            fn history<'py>(slf: &Bound<'py, Self>) -> PyResult<Numbers<'py>> {
                Ok(PyArray1::from_vec(slf.py(), shared(slf)?.interface.history()))
            }

            /// The same with the rounds since the last accepted step.
            fn augmented_history<'py>(slf: &Bound<'py, Self>) -> PyResult<Numbers<'py>> {
                Ok(PyArray1::from_vec(slf.py(), shared(slf)?.interface.augmented_history()))
            }

            /// Goes on from such numbers.
            fn set_history(slf: &Bound<'_, Self>, history: &Numbers<'_>) -> PyResult<()> {
                let py = slf.py();
                let mut this = exclusive(slf)?;
                let history = readable(history)?;
                let history = slice(py, &history)?;
                let interface = &mut this.interface;
                threads::attempt(py, || interface.set_history(history))?;
                this.current = false;
                Ok(())
            }
        }
    };
}

has_history!(Interface);
has_history!(Faces);
