//! The formula of a weight as Rust.

use proc_macro2::TokenStream;
use quote::quote;

use crate::formula::Formula;

/// A formula in `r` as an expression of Rust, of any number type `T`.
pub(super) fn formula(of: &Formula) -> TokenStream {
    let binary = |x: &Formula, operator: TokenStream, y: &Formula| {
        let (x, y) = (formula(x), formula(y));
        quote!((#x #operator #y))
    };
    match of {
        Formula::Number(value) => quote!(T::splat(#value)),
        Formula::Radius => quote!(r),
        Formula::Neg(x) => {
            let x = formula(x);
            quote!((-#x))
        }
        Formula::Add(x, y) => binary(x, quote!(+), y),
        Formula::Sub(x, y) => binary(x, quote!(-), y),
        Formula::Mul(x, y) => binary(x, quote!(*), y),
        Formula::Div(x, y) => binary(x, quote!(/), y),
        Formula::Power(x, exponent) => {
            let x = formula(x);
            let power = power(exponent.unsigned_abs());
            let value = if *exponent < 0 { quote!(T::ONE / #power) } else { power };
            quote!({ let x = #x; #value })
        }
        Formula::Exp(x) => {
            let x = formula(x);
            quote!(T::exp(#x))
        }
        Formula::Sqrt(x) => {
            let x = formula(x);
            quote!(T::sqrt(#x))
        }
        Formula::If { x, y, then, otherwise } => {
            let [x, y, then, otherwise] = [x, y, then, otherwise].map(|x| formula(x));
            quote!(T::select_less(#x, #y, #then, #otherwise))
        }
    }
}

/// `x` to a power, by squares.
fn power(exponent: u32) -> TokenStream {
    match exponent {
        0 => quote!(T::ONE),
        1 => quote!(x),
        _ => {
            let half = power(exponent / 2);
            let odd = (exponent % 2 == 1).then(|| quote!(x *));
            quote!((#odd { let x = #half; x * x }))
        }
    }
}
