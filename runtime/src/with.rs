//! Options that are given another value of one field.

/// `with! { /// Doc. with_field(field: Type); … }`: the functions of an `impl`.
macro_rules! with {
    ($($(#[$doc:meta])+ $function:ident($field:ident: $type:ty);)+) => {$(
        $(#[$doc])+
        #[must_use]
        pub const fn $function(self, $field: $type) -> Self {
            Self { $field, ..self }
        }
    )+};
}

pub(crate) use with;
