//! Kernels in C, from `emit --lang c`: compiled and run, beside the Rust kernels that the product has.

use std::fmt::Write as _;
use std::process::Command;

use diffuse_contact::{FacetElement, Generated};
use diffuse_contact_kernels::cubic_interpolating::CubicInterpolating;
use diffuse_contact_kernels::support::{
    Basis, Domains, ElementInputs, FrameRule, Isa, KernelSet as _, Masters, MaterialNode, Mode,
};

use crate::runs::{Run, Scratch, run};

/// Numbers in (−½, ½) that look random.
fn random(seed: f64) -> impl FnMut() -> f64 {
    let mut value = seed;
    move || {
        value = (value * 7.3 + 0.17).fract();
        value - 0.5
    }
}

fn header(arguments: &[&str]) -> String {
    let Run { code, stdout, stderr } = run(&[&["emit", "--lang", "c"], arguments].concat());
    assert_eq!((code, stderr.as_str()), (0, ""));
    stdout
}

fn list(numbers: &[f64]) -> String {
    numbers.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ")
}

/// What a program's `main` prints, compiled without fused products.
fn printed(name: &str, header: &str, body: &str) -> Vec<f64> {
    let scratch = Scratch::new(name);
    std::fs::write(scratch.path("kernel.h"), header).unwrap();
    let program = format!(
        "#include \"kernel.h\"\n#include <stdio.h>\n#include <string.h>\nint main(void) {{\n{body}return 0;\n}}\n"
    );
    std::fs::write(scratch.path("main.c"), program).unwrap();
    let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
    let mut compile = Command::new(compiler);
    compile.args(["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Werror", "-O1", "-ffp-contract=off"]);
    let compiled =
        compile.args([&scratch.path("main.c"), "-o", &scratch.path("main"), "-lm"]).output().unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let output = Command::new(scratch.path("main")).output().unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap().lines().map(|line| line.parse().unwrap()).collect()
}

/// Over the largest entry; a NaN is larger than anything.
fn largest_difference(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let largest = expected.iter().fold(f64::MIN_POSITIVE, |largest: f64, x| largest.max(x.abs()));
    found.iter().zip(expected).fold(0.0, |worst: f64, (x, y)| {
        let difference = (x - y).abs() / largest;
        if worst.is_nan() || difference <= worst { worst } else { difference }
    })
}

/// Entry i of element k at i * elements + k.
fn side_by_side(elements: &[Vec<f64>]) -> Vec<f64> {
    (0..elements[0].len()).flat_map(|i| elements.iter().map(move |numbers| numbers[i])).collect()
}

const NODES: usize = 9;

/// Nodes of a bumpy surface, where they were before, and a slave above it.
fn scene(seed: f64) -> (Vec<[f64; 3]>, Vec<MaterialNode>, [f64; 3]) {
    let mut random = random(seed);
    let place = |k: usize| [0, 1].map(|axis| (if axis == 0 { k % 3 } else { k / 3 }) as f64 - 1.0);
    let masters: Vec<[f64; 3]> = (0..NODES)
        .map(|k| {
            let [x, y] = place(k);
            [x + 0.1 * random(), y + 0.1 * random(), 0.1 * x * x - 0.05 * x * y + 0.1 * random()]
        })
        .collect();
    let material = (0..NODES).map(|k| {
        let [x, y] = place(k);
        let offset = [x - 0.1, y + 0.05, 0.05 * random()];
        MaterialNode { offset, metric: [0.5, 0.02, 0.0, 0.45, 0.01, 0.4] }
    });
    (masters, material.collect(), [0.2 * random(), 0.2 * random(), 0.15])
}

/// Gap, foot, normal, gradient and Hessian of the product's kernel, one element number by number.
fn by_rust(rule: FrameRule, inputs: &ElementInputs<'_>) -> Vec<f64> {
    let freedoms = 3 * (NODES + 1);
    let (mut gradient, mut hessian) = (vec![0.0; freedoms], vec![0.0; freedoms * (freedoms + 1) / 2]);
    let kernel = (Basis::Quadratic, rule, Mode::Hessian);
    let values = CubicInterpolating::gap(Isa::SCALAR, kernel, inputs, &mut gradient, &mut hessian);
    assert!(values.foot_residual < 1e-12 && values.pivot_ratio > 1e-3, "{values:?}");
    [&[values.gap], &values.foot[..], &values.normal, &gradient, &hessian].concat()
}

/// With the weight whose kernels the product shares with no other one: it is the same kernel. Only the products of the Hessian's rows are
/// added in another order.
#[test]
fn a_gap_in_c_is_that_of_the_product() {
    const AXES: [[f64; 3]; 3] = [[0.8, 0.6, 0.0], [-0.6, 0.8, 0.0], [0.0, 0.0, 1.0]];
    let rules = [(FrameRule::Held, "gap", "held"), (FrameRule::Material, "gap_material", "material")];
    for (rule, name, argument) in rules {
        let header = header(&[
            "--output",
            "gap",
            "--mode",
            "hessian",
            "--frame-derivative",
            argument,
            "--weight",
            "cubic-interpolating",
        ]);
        let scenes = [0.3, 0.7].map(scene);
        let (mut nodes, mut elements, mut expected) = (Vec::new(), Vec::new(), Vec::new());
        for (masters, material, slave) in &scenes {
            let is_material = rule == FrameRule::Material;
            let radii: Vec<f64> = (0..NODES).map(|k| 2.2 + 0.1 * k as f64).collect();
            let inputs = ElementInputs {
                slave: *slave,
                masters: Masters::Positions(masters),
                domains: if is_material { Domains::Material(material) } else { Domains::Each(&radii) },
                plane_reach: 0.0,
                t1: AXES[0],
                t2: AXES[1],
                normal: AXES[2],
                support_radius: 2.5,
                point: [0.0; 2],
                anchor: [0.0; 3],
                pole: 4,
            };
            expected.push(by_rust(rule, &inputs));
            elements.push([&slave[..], AXES.as_flattened(), &[4.0, 2.5]].concat());
            let of_node = |k: usize| {
                let domain = if is_material { inputs.material(k).to_vec() } else { vec![inputs.node(k)[3]] };
                [&masters[k][..], &domain].concat()
            };
            nodes.push((0..NODES).flat_map(of_node).collect::<Vec<f64>>());
        }
        let freedoms = 3 * (NODES + 1);
        let packed = freedoms * (freedoms + 1) / 2;
        let upper = name.to_uppercase();
        let mut body = format!(
            "static {name}_inputs inputs[2]; static {name}_node nodes[2 * {NODES}]; static {name}_values of_one;\n\
             static double g[{freedoms}], h[{packed}], values[2 * sizeof of_one / sizeof(double)], gradient[2 * {freedoms}], \
             hessian[2 * {packed}], scratch[DIFFUSE_CONTACT_LANES * {NODES} * {upper}_HESSIAN_SCRATCH];\n\
             static const double element_numbers[] = {{{}}}, node_numbers[] = {{{}}}, elements[] = {{{}}}, all_nodes[] = {{{}}};\n\
             if (sizeof element_numbers != sizeof inputs || sizeof node_numbers != sizeof nodes) return 1;\n\
             memcpy(inputs, element_numbers, sizeof inputs);\nmemcpy(nodes, node_numbers, sizeof nodes);\n\
             {name}_hessian_batch(2, {NODES}, elements, all_nodes, values, gradient, hessian, scratch);\n\
             for (int k = 0; k < 2; k++) {{\n\
             {name}_hessian({NODES}, inputs + k, nodes + k * {NODES}, &of_one, g, h, scratch);\n\
             const double *v = (const double *)&of_one;\n\
             for (size_t i = 0; i < sizeof of_one / sizeof(double); i++) if (v[i] != values[2 * i + k]) return 2;\n\
             for (int i = 0; i < {freedoms}; i++) if (g[i] != gradient[2 * i + k]) return 3;\n\
             for (int i = 0; i < {packed}; i++) if (h[i] != hessian[2 * i + k]) return 4;\n\
             printf(\"%.17g\\n\", of_one.gap);\n",
            list(&elements.concat()),
            list(&nodes.concat()),
            list(&side_by_side(&elements)),
            list(&side_by_side(&nodes))
        );
        for field in ["foot", "normal"] {
            let _ = writeln!(body, "for (int i = 0; i < 3; i++) printf(\"%.17g\\n\", of_one.{field}[i]);");
        }
        for (array, length) in [("g", freedoms), ("h", packed)] {
            let _ = writeln!(body, "for (int i = 0; i < {length}; i++) printf(\"%.17g\\n\", {array}[i]);");
        }
        body += "}\n";
        let found = printed(&format!("emit_c_{name}"), &header, &body);
        for (found, expected) in found.chunks(7 + freedoms + packed).zip(&expected) {
            let (found, found_hessian) = found.split_at(7 + freedoms);
            let (expected, expected_hessian) = expected.split_at(7 + freedoms);
            assert_eq!(found, expected, "{name}");
            let worst = largest_difference(found_hessian, expected_hessian);
            println!("{name}: {worst:.1e}");
            assert!(worst <= 1e-15, "{name}: {worst:e}");
        }
    }
}

#[test]
fn contact_on_facets_in_c_is_that_of_the_product_bit_for_bit() {
    for (shape, count) in [("triangle", 3), ("quadrilateral", 4)] {
        let header = header(&["--facet", shape, "--mode", "hessian"]);
        let name = format!("gap_over_{shape}");
        let freedoms = 3 * (count + 1);
        let packed = freedoms * (freedoms + 1) / 2;
        let square = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        for seed in [0.2, 0.5, 0.9] {
            let mut random = random(seed);
            let corner = |xy: &[f64; 2]| [xy[0] + 0.3 * random(), xy[1] + 0.3 * random(), 0.5 * random()];
            let corners: Vec<[f64; 3]> = square[..count].iter().map(corner).collect();
            let slave = [random(), random(), 0.4];
            let element = FacetElement { slave, corners: &corners };
            let gap = Generated.facet_gap(&element, Mode::Hessian).unwrap();
            let values = [&[gap.gap][..], &gap.foot, &gap.normal].concat();
            let expected = [&values[..], &gap.gradient, gap.hessian.packed()].concat();
            let numbers = list(&[&slave[..], corners.as_flattened()].concat());
            let body = format!(
                "static const double numbers[] = {{{numbers}}};\n{name}_inputs inputs; {name}_values values;\n\
                 static double gradient[{freedoms}], hessian[{packed}];\nmemcpy(&inputs, numbers, sizeof inputs);\n\
                 {name}_hessian(&inputs, &values, gradient, hessian);\nprintf(\"%.17g\\n\", values.gap);\n\
                 for (int i = 0; i < 3; i++) printf(\"%.17g\\n\", values.foot[i]);\n\
                 for (int i = 0; i < 3; i++) printf(\"%.17g\\n\", values.normal[i]);\n\
                 for (int i = 0; i < {freedoms}; i++) printf(\"%.17g\\n\", gradient[i]);\n\
                 for (int i = 0; i < {packed}; i++) printf(\"%.17g\\n\", hessian[i]);\n"
            );
            let found = printed(&format!("emit_c_{shape}"), &header, &body);
            assert_eq!(found, expected, "{shape}");
        }
    }
}

#[test]
fn what_has_no_kernel_in_c_is_refused() {
    for output in ["coefficients", "slip"] {
        run(&["emit", "--lang", "c", "--output", output, "--mode", "hessian"])
            .assert_refused(&["--lang c", output]);
    }
    run(&["emit", "--lang", "rust", "--output", "gap", "--mode", "value"]).assert_refused(&["--nodes"]);
}

/// The other kernels of a fit have a text that a compiler takes.
#[test]
fn every_other_output_is_a_header() {
    for output in ["coefficients", "surface", "slip"] {
        let header = header(&["--output", output, "--mode", "gradient", "--basis", "linear"]);
        printed(&format!("emit_c_{output}"), &header, &format!("(void){output}_gradient_batch;\n"));
        assert!(header.contains(&format!("static inline void {output}_gradient(size_t count, ")));
    }
}

/// The guard of an element's header would leave out the second of two that differ.
#[test]
fn headers_that_differ_are_not_included_together() {
    let scratch = Scratch::new("two-headers");
    let facet = |mode| header(&["--facet", "triangle", "--mode", mode]);
    for (name, text) in [("value.h", facet("value")), ("hessian.h", facet("hessian"))] {
        std::fs::write(scratch.path(name), text).unwrap();
    }
    for (second, error) in [("value.h", ""), ("hessian.h", "there are two elements")] {
        let program = format!("#include \"value.h\"\n#include \"{second}\"\n");
        std::fs::write(scratch.path("main.c"), program).unwrap();
        let compiler = std::env::var("CC").unwrap_or_else(|_| "cc".to_owned());
        let arguments = ["-std=c99", "-fsyntax-only"];
        let compiled = Command::new(compiler).args(arguments).arg(scratch.path("main.c")).output().unwrap();
        let found = String::from_utf8_lossy(&compiled.stderr);
        assert_eq!(compiled.status.success(), error.is_empty(), "{found}");
        assert!(found.contains(error), "{found}");
    }
}
