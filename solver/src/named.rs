//! Enums whose members have names in decks.

/// `named!(Kind { Member => "name", … })`: names of the members in decks, and all of them.
macro_rules! named {
    ($kind:ident { $($member:ident => $name:expr),+ $(,)? }) => {
        impl $kind {
            /// All of them, each with its name in decks.
            pub const NAMED: &[(&str, Self)] = &[$(($name, Self::$member)),+];

            /// Name in decks.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$member => $name),+
                }
            }
        }
    };
}

pub(crate) use named;
