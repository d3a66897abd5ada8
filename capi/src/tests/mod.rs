//! Calls as C makes them.
