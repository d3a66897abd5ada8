use diffuse_contact_solver::output::Watcher;
use diffuse_contact_solver::solve::{SolveOptions, solve};
use diffuse_contact_solver::statics::*;
struct W(bool);
impl Watcher for W {
    fn iteration(&mut self, r: &IterationRecord) {
        if self.0 {
            println!(
                "   t {:.5} it {:2} res {:.3e} abs {:.3e} act {} step {:.3}",
                r.time, r.iteration, r.relative, r.residual, r.active, r.step
            )
        }
    }
    fn cut_back(&mut self, e: f64, l: f64, f: &Failure) {
        println!("cut {e} {l}: {f}")
    }
    fn increment(&mut self, r: &IncrementRecord) -> Control {
        println!(
            "inc {} t {:.5} its {} act {} pen {:.3e} F {:?}",
            r.number, r.time, r.iterations, r.active, r.max_penetration, r.contact_forces
        );
        Control::Continue
    }
}
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let o = SolveOptions { out: a[2].clone().into(), restart: false, overwrite: true, threads: 1 };
    match solve(a[1].as_ref(), &o, &mut W(a.len() > 3)) {
        Ok(s) => println!("{s:#?}"),
        Err(e) => println!("ERR {e}"),
    }
}
