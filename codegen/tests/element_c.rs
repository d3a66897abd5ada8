//! The C header of elements: compiled with the C compiler and run, against the interpreter; and the checked-in text of a small one.
#![allow(non_snake_case)]

use std::fmt::Write as _;
use std::process::Command;

use diffuse_contact_codegen::expr::{Expr, Matrix, Vec3, Vector};
use diffuse_contact_codegen::interpret::{element_products, element_results};
use diffuse_contact_codegen::{Config, ConfigError, ElementKernels, ElementModel, Limits, Mode};

use crate::witnesses::{numbers, random, spring, tet4};

const GOLDEN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../generated/golden/element_spring.h");

/// Every operation that C has other words for, and names that are words of C.
fn words(m: &ElementModel<'_>) {
    let (x, long): (Vec3<'_>, Expr<'_>) = (m.variable("double"), m.parameter("long"));
    let log = m.define("log", x.norm());
    let angle = x[1].atan2(x[0]) + (log + long).ln() * x[2].sin() - x[0].cos().cbrt();
    let power = (log + 1.0).powf(long) / (1.0 + (-log).exp());
    m.residual("values", Vec3::from_fn(|k| [angle, power, x[0].max(x[1]).min(long)][k]));
    m.value("if_", x.unit());
}

/// A sum over two points, of what depends on them and of what does not.
fn points(m: &ElementModel<'_>) {
    let (x, k): (Vec3<'_>, Expr<'_>) = (m.variable("x"), m.parameter("k"));
    let (xi, weight): (Expr<'_>, Expr<'_>) =
        (m.points("point", &[[-0.5], [0.5]]), m.points("weight", &[[2.0], [3.0]]));
    let length = m.define("length", x.norm());
    m.energy(weight * (0.3 * k * length * (1.0 + xi)).exp());
    m.value("volume", Vec3::from_fn(|axis| weight * x[axis]));
}

/// A root, with a condition and a sum over points around it.
fn root(m: &ElementModel<'_>) {
    let (x, scale): (Vec3<'_>, Expr<'_>) = (m.variable("x"), m.parameter("scale"));
    let xi: Expr<'_> = m.points("xi", &[[-0.5], [0.5]]);
    let length = m.define("length", x.norm());
    let foot = m.root("switch", |u| {
        Vector([u[0] + 0.3 * u[1] * u[1] - 3.0 * length, u[1] + 0.2 * xi * u[0] * u[1] - x[0]])
    });
    m.energy(scale * foot.unknowns[0].max(0.1) * foot.unknowns[1]);
    m.value("residual", foot.residual);
    m.product();
}

/// Four equations from a start, and three that are linear without anything on the diagonal.
fn equations(m: &ElementModel<'_>) {
    let (x, scale): (Vector<'_, 4>, Expr<'_>) = (m.variable("x"), m.parameter("scale"));
    let limits = Limits { longest_step: 2.0, evaluations: 40 };
    let root = m.root_from("u", x, limits, |u| {
        Vector::from_fn(|k| u[k] + 0.1 * scale * u[(k + 1) % 4].powi(2) - 2.0 * x[k])
    });
    let matrix =
        Matrix::from_fn(|i, j| if i == j { m.sheet().zero() } else { x[i] + (1.0 + j as f64) * x[3] });
    let solution = m.solve("v", matrix, Vec3::from_fn(|k| root.unknowns[k]));
    m.energy(solution.unknowns.dot(solution.unknowns) * root.unknowns[3]);
    m.value("residuals", Vector([root.residual, solution.residual]));
}

/// Inputs of an element, in the order of its struct.
fn inputs_of(element: &ElementKernels, seed: f64) -> Vec<f64> {
    let mut seed = seed;
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].concat();
    let inputs = element.signature.inputs.iter();
    let values = inputs.flat_map(|input| match input.symbols.len() {
        12 => corners.iter().map(|corner| corner + 0.3 * random(&mut seed)).collect(),
        count => (0..count).map(|_| 1.0 + random(&mut seed)).collect::<Vec<f64>>(),
    });
    values.collect()
}

/// The numbers of each input.
fn split<'a>(element: &ElementKernels, numbers: &'a [f64]) -> Vec<&'a [f64]> {
    let mut rest = numbers;
    let inputs = element.signature.inputs.iter();
    inputs.map(|input| rest.split_off(..input.symbols.len()).unwrap()).collect()
}

/// A program that prints the results of each kernel for each element, first one by one, then as a batch.
fn program(element: &ElementKernels, elements: &[Vec<f64>]) -> String {
    let (name, count) = (&element.signature.name, elements.len());
    let numbers = |values: &[f64]| values.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ");
    let mut text =
        "#include \"elements.h\"\n#include <stdio.h>\n#include <string.h>\nint main(void) {\n".to_owned();
    let size = elements[0].len();
    let _ = writeln!(text, "static const double all[{count}][{size}] = {{{}}};", {
        elements.iter().map(|values| format!("{{{}}}", numbers(values))).collect::<Vec<_>>().join(", ")
    });
    let _ = writeln!(text, "static double columns[{size} * {count}];");
    let _ = writeln!(
        text,
        "for (int k = 0; k < {count}; k++) for (int i = 0; i < {size}; i++) columns[i * {count} + k] = all[k][i];"
    );
    for kernel in &element.kernels {
        let mode = kernel.spec.mode.name();
        let fields: usize =
            kernel.spec.signature.values.iter().map(|v| v.dimensions.iter().product::<usize>()).sum();
        let lengths: Vec<usize> =
            kernel.values[kernel.spec.signature.values.len()..].iter().map(|v| v.components.len()).collect();
        let arrays: String = (0..lengths.len()).map(|n| format!(", d{n}")).collect();
        let declare = |times: usize| -> String {
            lengths
                .iter()
                .enumerate()
                .map(|(n, length)| format!("static double d{n}[{}];", times * length))
                .collect()
        };
        let _ = writeln!(
            text,
            "for (int k = 0; k < {count}; k++) {{ {name}_inputs in; {name}_values v; double flat[{fields}]; {}",
            declare(1)
        );
        let _ = writeln!(
            text,
            "memcpy(&in, all[k], sizeof in); {name}_{mode}(&in, &v{arrays}); memcpy(flat, &v, sizeof v);"
        );
        let _ = writeln!(text, "for (int i = 0; i < {fields}; i++) printf(\"%.17g\\n\", flat[i]);");
        for (n, length) in lengths.iter().enumerate() {
            let _ = writeln!(text, "for (int i = 0; i < {length}; i++) printf(\"%.17g\\n\", d{n}[i]);");
        }
        let _ = writeln!(text, "}} {{ static double v[{fields} * {count}]; {}", declare(count));
        let _ = writeln!(
            text,
            "{name}_{mode}_batch({count}, columns, v{arrays}); for (int k = 0; k < {count}; k++) {{"
        );
        let _ =
            writeln!(text, "for (int i = 0; i < {fields}; i++) printf(\"%.17g\\n\", v[i * {count} + k]);");
        for (n, length) in lengths.iter().enumerate() {
            let _ = writeln!(
                text,
                "for (int i = 0; i < {length}; i++) printf(\"%.17g\\n\", d{n}[i * {count} + k]);"
            );
        }
        text.push_str("}}\n");
    }
    text + &products(element, count) + "return 0; }\n"
}

/// The vector that an element's derivatives are multiplied by.
fn direction_of(element: usize, entries: usize) -> Vec<f64> {
    numbers(entries, 0.23 + 0.05 * element as f64)
}

/// Prints the products of each element, first one by one, then as a batch.
fn products(element: &ElementKernels, count: usize) -> String {
    let (name, entries) = (&element.signature.name, element.signature.variables());
    let lengths: Vec<usize> =
        element.product.iter().flat_map(|kernel| &kernel.values).map(|v| v.components.len()).collect();
    let list = |x: Vec<f64>| x.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ");
    let directions: Vec<Vec<f64>> = (0..count).map(|k| direction_of(k, entries)).collect();
    let columns = (0..entries).flat_map(|i| directions.iter().map(move |v| v[i])).collect();
    let mut text = format!(
        "{{ static const double v[] = {{{}}}, v_columns[] = {{{}}};\n",
        list(directions.concat()),
        list(columns)
    );
    let arrays: String = (0..lengths.len()).map(|n| format!(", p{n}")).collect();
    for (n, length) in lengths.iter().enumerate() {
        let _ = writeln!(text, "static double p{n}[{length} * {count}];");
    }
    let _ = writeln!(
        text,
        "for (int k = 0; k < {count}; k++) {{ {name}_inputs in; memcpy(&in, all[k], sizeof in);\n\
         {name}_product(&in, v + {entries} * k{arrays});"
    );
    for (n, length) in lengths.iter().enumerate() {
        let _ = writeln!(text, "for (int i = 0; i < {length}; i++) printf(\"%.17g\\n\", p{n}[i]);");
    }
    let _ = writeln!(
        text,
        "}} {name}_product_batch({count}, columns, v_columns{arrays}); for (int k = 0; k < {count}; k++) {{"
    );
    for (n, length) in lengths.iter().enumerate() {
        let _ =
            writeln!(text, "for (int i = 0; i < {length}; i++) printf(\"%.17g\\n\", p{n}[i * {count} + k]);");
    }
    text + "}}\n"
}

/// What a program prints, with these options of the compiler.
fn printed(name: &str, header: &str, program: &str, options: &[&str]) -> Vec<f64> {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("elements.h"), header).unwrap();
    std::fs::write(folder.join("main.c"), program).unwrap();
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let mut compile = Command::new(compiler);
    compile.args(["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror"]).args(options);
    let compiled = compile.args(["main.c", "-o", "main", "-lm"]).current_dir(&folder).output().unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let output = Command::new(folder.join("main")).output().unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap().lines().map(|line| line.parse().unwrap()).collect()
}

#[test]
fn compiled_c_has_the_numbers_of_the_interpreter() {
    let all = [
        ("tet4", tet4 as fn(&ElementModel<'_>)),
        ("words", words),
        ("points", points),
        ("root", root),
        ("equations", equations),
    ];
    for (name, formulas) in all {
        let formulas = |m: &ElementModel<'_>| {
            formulas(m);
            m.product();
        };
        let element = ElementKernels::new(name, formulas).unwrap();
        let header = Config::new().element(name, formulas).unwrap().c_source().unwrap();
        let elements: Vec<Vec<f64>> =
            (0..5).map(|k| inputs_of(&element, 0.31 + 0.07 * f64::from(k))).collect();
        let mut all = Vec::new();
        for kernel in &element.kernels {
            let of = |x: &Vec<f64>| {
                element_results(kernel, &split(&element, x), &[]).into_iter().flat_map(|(_, x)| x)
            };
            let results: Vec<Vec<f64>> = elements.iter().map(|x| of(x).collect()).collect();
            all.extend([results.concat(), results.concat()].concat());
        }
        let product = |(k, x): (usize, &Vec<f64>)| {
            let direction = direction_of(k, element.signature.variables());
            let products =
                element_products(element.product.as_ref().unwrap(), &split(&element, x), &[], &direction);
            products.into_iter().flat_map(|(_, x)| x).collect::<Vec<f64>>()
        };
        let products: Vec<f64> = elements.iter().enumerate().flat_map(product).collect();
        all.extend([&products[..], &products].concat());
        let program = program(&element, &elements);
        for options in [&["-O0"][..], &["-O3"]] {
            let found = printed(name, &header, &program, options);
            assert_eq!(found.len(), all.len());
            let differences = found.iter().zip(&all).map(|(x, y)| (x - y).abs() / (1.0 + y.abs()));
            // A NaN stays.
            let worst = differences.fold(0.0, |x: f64, y| if x.is_nan() || x > y { x } else { y });
            println!("{name} {options:?}: {} numbers, largest relative difference {worst:.1e}", all.len());
            assert!(worst < 1e-12, "{name}: {worst:e}");
        }
    }
}

/// Equations that are singular or no numbers have residuals that any comparison finds.
#[test]
fn compiled_c_reports_equations_without_a_root() {
    let formulas = |m: &ElementModel<'_>| {
        let x: Expr<'_> = m.variable("x");
        let line = Vector([x, 2.0 * x]);
        let singular = m.solve("pair", Matrix([line.0, line.0]), Vector([x, 2.0 * x]));
        let rows = Matrix::from_fn(|i, j| x * f64::from((i * j) as u8));
        let zero = m.solve("three", rows, Vec3::from_fn(|_| x));
        let least = m.minimum("least", |u: Vector<'_, 2>| u[0] * u[0] + u[1] * u[1] + (-x).ln());
        let none = m.root("none", |u: Vector<'_, 1>| u - Vector([(-x).sqrt()]));
        let residuals = [singular.residual, zero.residual, none.residual, least.residual];
        m.value("residuals", Vector(residuals));
    };
    let header = Config::new().element("singular", formulas).unwrap().c_source().unwrap();
    let program = "#include \"elements.h\"\n#include <stdio.h>\nint main(void) {\n\
                   const singular_inputs in = {1.0}; singular_values v; singular_value(&in, &v);\n\
                   for (int k = 0; k < 4; k++) printf(\"%d\\n\", v.residuals[k] > 1e-12);\nreturn 0; }\n";
    for options in [&["-O0"][..], &["-O3"]] {
        assert_eq!(printed("singular", &header, program, options), [1.0, 1.0, 1.0, 0.0]);
    }
}

/// Members have the names of the formulas, but for words of C, and elements names that differ in more than the case of letters.
#[test]
fn names_in_c_are_those_of_the_formulas() {
    let formulas = |m: &ElementModel<'_>| {
        let [k, count, long] = m.parameters(["k", "count", "long"]);
        let x: Expr<'_> = m.variable("inputs");
        m.energy(k * x * x + count * long * x);
        m.value("values", k);
    };
    let header = Config::new().element("spring", formulas).unwrap().c_source().unwrap();
    for member in ["double k;", "double count;", "double long_;", "double inputs;", "double values;"] {
        assert!(header.contains(member), "{member}");
    }
    let program = "#include \"elements.h\"\n#include <stdio.h>\nint main(void) {\n\
                   const spring_inputs in = {.k = 2.0, .count = 3.0, .long_ = 1.0, .inputs = 4.0}; spring_values v;\n\
                   spring_value(&in, &v); printf(\"%g\\n%g\\n\", v.energy, v.values);\nreturn 0; }\n";
    assert_eq!(printed("names", &header, program, &[]), [44.0, 2.0]);
    let both = Config::new().element("Spring", formulas).unwrap().element("spring", formulas).unwrap();
    let error = both.c_source().unwrap_err();
    assert!(
        matches!(&error, ConfigError::DuplicateInUpperCase { name, other } if name == "spring" && other == "Spring"),
        "{error}"
    );
    assert!(both.source().is_ok());
    let residuals = |m: &ElementModel<'_>| {
        let x: Expr<'_> = m.variable("x");
        m.residual("r", x * x);
        m.residual("R", x);
    };
    let error = Config::new().element("two", residuals).unwrap().c_source().unwrap_err();
    assert!(matches!(&error, ConfigError::DuplicateConstant { name } if name == "TWO_R_JACOBIAN"), "{error}");
}

/// With a compiler for C++, which a machine may lack, the headers are C++ as well.
#[test]
fn headers_are_those_of_cpp_too() {
    let formulas = |m: &ElementModel<'_>| {
        let [new, null, errno, huge] = m.parameters(["new", "NULL", "errno", "HUGE_VAL"]);
        let x: Expr<'_> = m.variable("x");
        let root = m.root("template", |u: Vector<'_, 1>| u * u[0] - Vector([x * x + new]));
        m.energy(errno * null * huge * x * x * root.unknowns[0]);
    };
    let config = Config::new().element("spring", formulas).unwrap().element("fitted", fitted).unwrap();
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("cpp");
    std::fs::create_dir_all(&folder).unwrap();
    let program =
        "#include <errno.h>\n#define restrict mine\n#include \"elements.h\"\n#include \"elements.h\"\n";
    for (name, text) in [("elements.h", config.c_source().unwrap()), ("main.cpp", program.to_owned())] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let mut compile = Command::new(std::env::var("CXX").unwrap_or_else(|_| "c++".to_owned()));
    compile.args(["-std=c++11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "main.cpp"]);
    match compile.current_dir(&folder).output() {
        Ok(output) => assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr)),
        Err(error) => {
            assert!(std::env::var_os("DIFFUSE_CONTACT_REQUIRE_TOOLS").is_none(), "{error}");
            eprintln!("there is no compiler for C++: {error}");
        }
    }
}

/// A spring to a weighted average, and a fit with a root of it: loops over nodes, values kept between them, products of rows.
fn fitted(m: &ElementModel<'_>) {
    let (x, stiffness): (Vec3<'_>, Expr<'_>) = (m.variable("x"), m.parameter("node"));
    let (X, w): (Vec3<'_>, Expr<'_>) = (m.node_variable("X"), m.node_parameter("form"));
    let mean = m.define("mean", X.map(|X| (w * X).sum() / w.sum()));
    let fit = m.stationary("alpha", |alpha: Vector<'_, 2>| {
        let e = X[2] - alpha[0] - alpha[1] * (X[0] - mean[0]);
        w * e * e
    });
    let [height, slope] = fit.unknowns.0;
    let foot = m.minimum("foot", |u| {
        let distance = height + slope * u[0] - x[2];
        0.5 * (u[0] - x[0]).powi(2) + 0.5 * (u[1] - x[1]).powi(2) + 0.5 * distance * distance
    });
    let [u, v] = foot.unknowns.0;
    let ring = m.root("ring", |u: Vector<'_, 4>| {
        Vector::from_fn(|k| u[k] + 0.1 * u[(k + 1) % 4].powi(2) - 0.3 * mean[k % 3] - 0.2 * height)
    });
    m.residual("gap", x - mean);
    m.energy(
        0.5 * stiffness * (x - mean).dot(x - mean) + u * v + height.exp() + ring.unknowns.dot(ring.unknowns),
    );
    m.value("residual", foot.residual);
    m.product();
}

/// Inputs of one element: its own numbers, then those of its nodes.
fn fitted_numbers(count: usize, seed: &mut f64) -> (Vec<f64>, Vec<f64>) {
    let x = (0..3).map(|_| random(seed)).chain([1.3]).collect();
    let node = |k: usize| {
        let [a, b, c, w] = [0; 4].map(|_| random(seed));
        [a + 0.3 * k as f64, b, c, 1.0 + w]
    };
    (x, (0..count).flat_map(node).collect())
}

/// A program that prints all results of each element, first of functions for one, then of the batch.
fn program_with_nodes(
    elements: &[(Vec<f64>, Vec<f64>)],
    arrays: &[(&str, usize)],
    products: &[(&str, usize)],
) -> String {
    let (all, count) = (elements.len(), elements[0].1.len() / 4);
    let list = |x: &[f64]| x.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ");
    let columns = |of: &dyn Fn(usize) -> Vec<f64>| {
        let of: Vec<Vec<f64>> = (0..all).map(of).collect();
        list(&(0..of[0].len()).flat_map(|i| of.iter().map(move |x| x[i])).collect::<Vec<f64>>())
    };
    let mut text = format!(
        "#include \"elements.h\"\n#include <stdio.h>\n#include <string.h>\nint main(void) {{\n\
         static const double inputs[] = {{{}}}, nodes[] = {{{}}};\n\
         static const double side_by_side[] = {{{}}}, nodes_side_by_side[] = {{{}}};\n\
         static double flat[5], all_flat[5 * {all}], scratch[DIFFUSE_CONTACT_LANES * {count} * FITTED_HESSIAN_SCRATCH];\n\
         fitted_inputs of_one; fitted_node of_nodes[{count}]; fitted_values values;\n",
        list(&elements.iter().flat_map(|(x, _)| x.clone()).collect::<Vec<_>>()),
        list(&elements.iter().flat_map(|(_, nodes)| nodes.clone()).collect::<Vec<_>>()),
        columns(&|k| elements[k].0.clone()),
        columns(&|k| elements[k].1.clone()),
    );
    for (name, length) in arrays {
        let _ = writeln!(text, "static double {name}[{length}], all_{name}[{length} * {all}];");
    }
    let names: Vec<&str> = arrays.iter().map(|(name, _)| *name).collect();
    let _ = writeln!(
        text,
        "for (int k = 0; k < {all}; k++) {{ memcpy(&of_one, inputs + 4 * k, sizeof of_one); memcpy(of_nodes, nodes + {} * k, sizeof of_nodes);\n\
         fitted_hessian({count}, &of_one, of_nodes, &values, {}, scratch); memcpy(flat, &values, sizeof values);",
        4 * count,
        names.join(", ")
    );
    for (name, length) in [("flat", 5)].iter().chain(arrays) {
        let _ = writeln!(text, "for (int i = 0; i < {length}; i++) printf(\"%.17g\\n\", {name}[i]);");
    }
    let _ = writeln!(
        text,
        "}}\nfitted_hessian_batch({all}, {count}, side_by_side, nodes_side_by_side, all_flat, all_{}, scratch);\n\
         for (int k = 0; k < {all}; k++) {{",
        names.join(", all_")
    );
    for (name, length) in [("flat", 5)].iter().chain(arrays) {
        let _ = writeln!(
            text,
            "for (int i = 0; i < {length}; i++) printf(\"%.17g\\n\", all_{name}[i * {all} + k]);"
        );
    }
    text.push_str("}\n");
    let variables = 3 + 3 * count;
    let _ = writeln!(
        text,
        "static const double v[] = {{{}}}, v_side_by_side[] = {{{}}};\n\
         static double of_nodes_products[DIFFUSE_CONTACT_LANES * {count} * FITTED_PRODUCT_SCRATCH + 1];",
        list(&(0..all).flat_map(|k| direction_of(k, variables)).collect::<Vec<_>>()),
        columns(&|k| direction_of(k, variables)),
    );
    for (name, length) in products {
        let _ = writeln!(text, "static double {name}[{length}], all_{name}[{length} * {all}];");
    }
    let names: Vec<&str> = products.iter().map(|(name, _)| *name).collect();
    let _ = writeln!(
        text,
        "for (int k = 0; k < {all}; k++) {{ memcpy(&of_one, inputs + 4 * k, sizeof of_one); memcpy(of_nodes, nodes + {} * k, sizeof of_nodes);\n\
         fitted_product({count}, &of_one, of_nodes, v + {variables} * k, {}, of_nodes_products);",
        4 * count,
        names.join(", ")
    );
    for (name, length) in products {
        let _ = writeln!(text, "for (int i = 0; i < {length}; i++) printf(\"%.17g\\n\", {name}[i]);");
    }
    let _ = writeln!(
        text,
        "}}\nfitted_product_batch({all}, {count}, side_by_side, nodes_side_by_side, v_side_by_side, all_{}, of_nodes_products);\n\
         for (int k = 0; k < {all}; k++) {{",
        names.join(", all_")
    );
    for (name, length) in products {
        let _ = writeln!(
            text,
            "for (int i = 0; i < {length}; i++) printf(\"%.17g\\n\", all_{name}[i * {all} + k]);"
        );
    }
    text + "} return 0; }\n"
}

#[test]
fn compiled_c_has_the_numbers_of_the_interpreter_for_any_number_of_nodes() {
    let element = ElementKernels::new("fitted", fitted).unwrap();
    let header = Config::new().element("fitted", fitted).unwrap().c_source().unwrap();
    let mut seed = 0.37;
    // Fewer elements than lanes, and more, but no multiple.
    for (all, count, options) in [(1, 3, &["-O1"][..]), (5, 8, &["-O3"]), (11, 4, &["-O3", "-march=native"])]
    {
        let elements: Vec<_> = (0..all).map(|_| fitted_numbers(count, &mut seed)).collect();
        let results: Vec<Vec<(String, Vec<f64>)>> = elements
            .iter()
            .map(|(x, nodes)| {
                let nodes: Vec<&[f64]> = nodes.chunks(4).collect();
                element_results(&element.kernels[2], &[&x[..3], &x[3..]], &nodes)
            })
            .collect();
        let arrays: Vec<(&str, usize)> =
            results[0].iter().skip(3).map(|(name, values)| (name.as_str(), values.len())).collect();
        let product = |(k, (x, nodes)): (usize, &(Vec<f64>, Vec<f64>))| {
            let nodes: Vec<&[f64]> = nodes.chunks(4).collect();
            let (kernel, direction) = (element.product.as_ref().unwrap(), direction_of(k, 3 + 3 * count));
            element_products(kernel, &[&x[..3], &x[3..]], &nodes, &direction)
        };
        let products: Vec<_> = elements.iter().enumerate().map(product).collect();
        let product_arrays: Vec<(&str, usize)> =
            products[0].iter().map(|(name, values)| (name.as_str(), values.len())).collect();
        let program = program_with_nodes(&elements, &arrays, &product_arrays);
        let found = printed("fitted", &header, &program, options);
        let expected: Vec<Vec<f64>> = results
            .iter()
            .map(|results| results.iter().flat_map(|(_, values)| values.clone()).collect())
            .collect();
        let length = expected[0].len();
        let (found, found_products) = found.split_at(2 * all * length);
        let products: Vec<f64> = products.into_iter().flatten().flat_map(|(_, values)| values).collect();
        assert_eq!(found_products.len(), 2 * products.len());
        for (found, expected) in found_products.iter().zip(products.iter().chain(&products)) {
            assert!((found - expected).abs() <= 1e-12 * (1.0 + expected.abs()), "{found} {expected}");
        }
        for (found, expected) in found.chunks(length).zip(expected.iter().chain(&expected)) {
            assert!(found[4] < 1e-12 && expected[4] < 1e-12, "the foot is found");
            for (k, (found, expected)) in found.iter().zip(expected).enumerate().filter(|(k, _)| *k != 4) {
                assert!(
                    (found - expected).abs() <= 1e-12 * (1.0 + expected.abs()),
                    "{k}: {found} {expected}"
                );
            }
        }
    }
}

#[test]
fn the_golden_header_is_what_the_generator_emits() {
    let config = Config::new().element("spring", spring);
    let text = config.unwrap().c_source().unwrap();
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(GOLDEN, &text).unwrap();
    }
    let golden = std::fs::read_to_string(GOLDEN).unwrap_or_default();
    assert!(
        text == golden,
        "the emitted text has changed; refresh the excerpt and review the difference:\n    \
         UPDATE_GOLDEN=1 cargo test -p diffuse-contact-codegen --test all -- golden"
    );
    assert_eq!(Mode::ALL.map(|mode| text.contains(&format!("spring_{}_batch", mode.name()))), [true; 3]);
}
