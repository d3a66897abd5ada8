//! What all command lines have in common.

use std::process::ExitCode;

use clap::builder::{PossibleValuesParser, TypedValueParser};

use crate::error::report;

/// Parser for a choice by name.
pub fn named<T: Copy + Send + Sync + 'static, const COUNT: usize>(
    all: [T; COUNT],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.map(name)).map(move |given| {
        let found = all.into_iter().find(|&choice| name(choice) == given);
        found.expect("clap lets no other name through")
    })
}

/// The same, with names that other builds have, with a Cargo feature: they are refused with the feature's name.
pub fn named_or_left_out<T: Copy + Send + Sync + 'static, const COUNT: usize>(
    all: [T; COUNT],
    name: fn(T) -> &'static str,
    (left_out, feature): (&'static [&'static str], &'static str),
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.map(name).into_iter().chain(left_out.iter().copied())).try_map(
        move |given| {
            let found = all.into_iter().find(|&choice| name(choice) == given);
            found.ok_or_else(|| format!("it needs a program built with --features {feature}"))
        },
    )
}

/// Prints help and version as clap lays them out, and a wrong argument as one sentence.
pub fn answer(answer: &clap::Error) -> ExitCode {
    if !answer.use_stderr() {
        // A closed pipe is no reason to complain.
        let _ = answer.print();
        return ExitCode::SUCCESS;
    }
    report(&one_sentence(&answer.render().to_string()));
    ExitCode::from(crate::BAD_INPUT)
}

/// The statement of a clap message: everything before the usage, on one line, without the leading `error:`.
fn one_sentence(message: &str) -> String {
    let lines = message
        .lines()
        .map(str::trim)
        .take_while(|line| !line.starts_with("Usage:") && !line.starts_with("For more information"))
        .filter(|line| !line.is_empty());
    let mut statement = String::new();
    for line in lines {
        let separator = if statement.is_empty() {
            ""
        } else if line.starts_with("tip:") {
            "; "
        } else {
            " "
        };
        statement.push_str(separator);
        statement.push_str(line);
    }
    format!("{} (see --help)", statement.strip_prefix("error: ").unwrap_or(&statement))
}

#[cfg(test)]
mod tests {
    use clap::{Parser, ValueEnum};

    use super::*;

    #[derive(Debug, Parser)]
    #[command(name = "program")]
    struct Arguments {
        #[arg(long, value_enum)]
        #[allow(dead_code, reason = "it is parsed, and refused")]
        kind: Option<Kind>,
        #[arg(long, value_parser = named_or_left_out([1, 2], name, (&["three"], "threes")))]
        number: Option<usize>,
    }

    fn name(number: usize) -> &'static str {
        ["one", "two"][number - 1]
    }

    #[derive(Clone, Debug, ValueEnum)]
    enum Kind {
        One,
        Other,
    }

    #[test]
    fn a_name_of_other_builds_is_refused_with_its_feature() {
        let number =
            |name| Arguments::try_parse_from(["program", "--number", name]).map(|given| given.number);
        assert_eq!(number("two").unwrap(), Some(2));
        assert_eq!(
            one_sentence(&number("three").unwrap_err().render().to_string()),
            "invalid value 'three' for '--number <NUMBER>': it needs a program built with --features threes (see --help)"
        );
        let error = number("four").unwrap_err().render().to_string();
        assert!(error.contains("[possible values: one, two, three]"), "{error}");
    }

    #[test]
    fn a_wrong_argument_is_one_sentence() {
        let error = Arguments::try_parse_from(["program", "--kind", "x"]).unwrap_err();
        assert_eq!(
            one_sentence(&error.render().to_string()),
            "invalid value 'x' for '--kind <KIND>' [possible values: one, other] (see --help)"
        );
        let error = Arguments::try_parse_from(["program", "--kindd", "one"]).unwrap_err();
        assert_eq!(
            one_sentence(&error.render().to_string()),
            "unexpected argument '--kindd' found; tip: a similar argument exists: '--kind' (see --help)"
        );
    }
}
