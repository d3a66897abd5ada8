use diffuse_contact::*;
fn main() {
    let mut seed = 12345u64;
    let mut rnd = || { seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407); ((seed >> 33) as f64) / ((1u64 << 31) as f64) };
    for n in [6usize, 7, 9, 12, 24, 30] {
        for basis in [Basis::Quadratic, Basis::Linear] {
            let masters: Vec<[f64; 3]> = (0..n).map(|_| { let (x, y) = (2.0 * rnd() - 1.0, 2.0 * rnd() - 1.0); [x, y, 0.2 * x * x - 0.1 * x * y + 0.3 * y + 0.05 * rnd()] }).collect();
            let frame = Frame::average_plane(&masters, [0.0, 0.0, 1.0]).unwrap();
            let e = Element { slave: [0.1, 0.05, 0.3], masters: &masters, frame, support_radius: 1.9, basis, weight: Weight::Cubic };
            let d = |a: &[f64], b: &[f64]| { let s = b.iter().fold(0.0f64, |m, x| m.max(x.abs())); a.iter().zip(b).fold(0.0f64, |m, (x, y)| m.max((x - y).abs())) / s };
            match (Generated.gap(&e, Mode::Hessian), ad::Ad.gap(&e, Mode::Hessian)) {
                (Ok(a), Ok(b)) => println!("{n} {basis:?} g {:e} nu {:e} foot {:e} N {:e} M {:e} al {:e}", (a.gap - b.gap).abs(), d(&a.normal, &b.normal), d(&a.foot, &b.foot), d(&a.gradient, &b.gradient), d(a.hessian.packed(), b.hessian.packed()), d(&a.coefficients, &b.coefficients)),
                (a, b) => println!("{n} {basis:?} {:?} {:?}", a.err(), b.err()),
            }
            match (Generated.surface(&e, [0.1, 0.2], Mode::Hessian), ad::Ad.surface(&e, [0.1, 0.2], Mode::Hessian)) {
                (Ok(a), Ok(b)) => println!("    f {:e} sl {:e} cu {:e} grad {:e} T {:e} H {:e}", (a.value - b.value).abs(), d(&a.slopes, &b.slopes), d(&a.curvatures, &b.curvatures), d(&a.gradient, &b.gradient), d(&a.slope_gradients[1], &b.slope_gradients[1]), d(a.hessian.packed(), b.hessian.packed())),
                (a, b) => println!("{n} {basis:?} {:?} {:?}", a.err(), b.err()),
            }
            match (Generated.coefficients(&e, Mode::Hessian), ad::Ad.coefficients(&e, Mode::Hessian)) {
                (Ok(a), Ok(b)) => println!("    al {:e} dal {:e} ddal {:e}", d(&a.values, &b.values), d(&a.gradients[2], &b.gradients[2]), d(a.hessians[2].packed(), b.hessians[2].packed())),
                (a, b) => println!("{n} {basis:?} {:?} {:?}", a.err(), b.err()),
            }
        }
    }
}
