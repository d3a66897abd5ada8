//! The kernels of the contact element: which outputs of the model are evaluated, with how many derivatives.

use super::basis::{Basis, MOST_COEFFICIENTS};
use super::diffuse::{Diffuse, FootQuantity};
use super::weight::Weight;
use crate::expr::{Expr, Sheet, System, Vector, total};
use crate::graph::{ExprId, Graph, Scope};
use crate::kernel::{CHECKSUM, Equation, Kernel, Mode, Value};
use crate::structure::{Functional, Gradient, LowRankForm, NodeProblem};

/// What a kernel computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Output {
    /// α and its derivatives.
    Coefficients,
    /// f, f_l, f_lm at a given in-plane point, ∇f, T_l, H_f.
    Surface,
    /// g, foot, ν, N, M.
    Gap,
    /// The same, and the slip from an anchor: q, ∇q, ∇²q, and the nodes' weights φ in the foot.
    Slip,
}

impl Output {
    /// All outputs.
    pub const ALL: [Self; 4] = [Self::Coefficients, Self::Surface, Self::Gap, Self::Slip];

    /// Name in emitted code.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Coefficients => "coefficients",
            Self::Surface => "surface",
            Self::Gap => "gap",
            Self::Slip => "slip",
        }
    }

    /// Whether it has a gap, and so a foot and a frame that may move.
    pub const fn has_gap(self) -> bool {
        matches!(self, Self::Gap | Self::Slip)
    }
}

/// What the local frame does while differentiating.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Default)]
pub enum FrameRule {
    /// It is held, as in the paper.
    #[default]
    Held,
    /// It is the average plane of the master nodes and moves with them: angular momentum is conserved.
    CoMoving,
    /// It is that plane with the nodes weighted in the master's first configuration, where their domains of influence stay what
    /// they are: the gap is one function of all positions wherever the slave slides.
    Material,
}

impl FrameRule {
    /// All rules.
    pub const ALL: [Self; 3] = [Self::Held, Self::CoMoving, Self::Material];
}

/// What identifies a kernel, besides the number of nodes, which stays open until emission.
#[derive(Clone, Debug, PartialEq)]
pub struct KernelSpec {
    /// What is computed.
    pub output: Output,
    /// With how many derivatives.
    pub mode: Mode,
    /// Basis of the fit.
    pub basis: Basis,
    /// Weight of the fit.
    pub weight: Weight,
    /// Frame rule.
    pub frame: FrameRule,
}

impl KernelSpec {
    /// All kernels of a basis and a weight. A moving frame makes a difference to gap and slip only, and needs a basis that is
    /// [isotropic](Basis::is_isotropic); the value of the gap is the same, but not whether there is an average plane.
    pub fn all(basis: Basis, weight: &Weight) -> Vec<Self> {
        let spec = |output, mode, frame| Self { output, mode, basis, weight: weight.clone(), frame };
        let mut all: Vec<Self> = Output::ALL
            .into_iter()
            .flat_map(|output| Mode::ALL.map(|mode| spec(output, mode, FrameRule::Held)))
            .collect();
        if basis.is_isotropic() {
            for output in [Output::Gap, Output::Slip] {
                for frame in [FrameRule::CoMoving, FrameRule::Material] {
                    all.extend(Mode::ALL.map(|mode| spec(output, mode, frame)));
                }
            }
        }
        all
    }
}

const COEFFICIENT_NAMES: [&str; MOST_COEFFICIENTS] = [
    "alpha_0", "alpha_1", "alpha_2", "alpha_3", "alpha_4", "alpha_5", "alpha_6", "alpha_7", "alpha_8",
    "alpha_9", "alpha_10", "alpha_11", "alpha_12", "alpha_13", "alpha_14",
];

impl Kernel<KernelSpec> {
    /// Builds a kernel from the model.
    pub fn new(spec: KernelSpec) -> Self {
        let equations = vec![
            Equation {
                formula: "(a, b, z)_i = Q (x^i - x^c) / R, Q = (t1, t2, n)",
                source: "local offsets over the support radius",
            },
            match spec.frame {
                FrameRule::Material => Equation {
                    formula: "w = w(r), r = |U (X_k - Xi)|",
                    source: "Chamoret et al. 2008, eq. 14, in the first configuration; docs/equations.md, T18",
                },
                FrameRule::Held | FrameRule::CoMoving => Equation {
                    formula: "w = w(r), r = sqrt(a^2 + b^2) R / R_k",
                    source: "Chamoret et al. 2008, eq. 14; R_k: docs/equations.md, T14",
                },
            },
            Equation {
                formula: "A alpha = beta, A = sum w p p^T, beta = sum w z p",
                source: "Chamoret et al. 2008, eq. 13",
            },
        ];
        let mut graph = Graph::new();
        let mut results = Results { equations, ..Results::default() };
        graph.write(|sheet| {
            let model = Diffuse::declare(sheet, spec.basis, &spec.weight, spec.frame);
            match spec.output {
                Output::Coefficients => results.coefficients(&spec, &model),
                Output::Surface => results.surface(&spec, &model),
                Output::Gap | Output::Slip => results.gap(&spec, &model),
            }
            results.checksum(sheet);
        });
        let Results { values, gradients, hessians, node_values, combinations, equations } = results;
        Self { spec, graph, values, gradients, hessians, node_values, combinations, equations }
    }
}

/// What a kernel computes, while it is written.
#[derive(Default)]
struct Results {
    values: Vec<Value>,
    gradients: Vec<(&'static str, Gradient)>,
    hessians: Vec<(&'static str, LowRankForm)>,
    node_values: Vec<(&'static str, ExprId)>,
    combinations: Vec<(&'static str, Vec<ExprId>)>,
    equations: Vec<Equation>,
}

impl Results {
    fn coefficients(&mut self, spec: &KernelSpec, model: &Diffuse<'_>) {
        let fit = model.fit(model.slave_point());
        let alpha = model.coefficients(&fit);
        self.array("coefficients", "Coefficients α, units length, 1, 1, 1/length, … (eq. 13)", &alpha);
        let functionals: Vec<(&'static str, Functional<'_>)> = (0..spec.basis.size())
            .map(|k| (COEFFICIENT_NAMES[k], model.coefficient_functional(&fit, k)))
            .collect();
        self.derivatives(spec.mode, &fit.problem, &functionals, functionals.len());
        self.pivot_ratio(fit.problem.system());
    }

    fn surface(&mut self, spec: &KernelSpec, model: &Diffuse<'_>) {
        let sheet = model.sheet();
        let point = ["point_1", "point_2"].map(|name| {
            model.dimensionless(sheet.input(name, Scope::Element)).bind(&format!("scaled_{name}"))
        });
        let point = Vector(point);
        let fit = model.fit(point);
        let at_point = model.surface(&fit, point);
        let [f, f1, f2] = model.surface_functionals(&fit, &at_point);
        let in_units = model.surface_in_units(&at_point);
        self.scalar("value", "Height f over the slave, length", in_units.value);
        self.array("slopes", "f_1, f_2", &in_units.slopes.0);
        self.array("curvatures", "f_11, f_12, f_22, 1/length", &in_units.curvatures.0);
        self.derivatives(spec.mode, &fit.problem, &[("f", f), ("f_1", f1), ("f_2", f2)], 1);
        self.pivot_ratio(fit.problem.system());
        self.equations
            .push(Equation { formula: "f(u) = p(u) alpha", source: "Chamoret et al. 2008, eq. 13" });
    }

    fn gap(&mut self, spec: &KernelSpec, model: &Diffuse<'_>) {
        let fit = model.fit(model.slave_point());
        let alpha = model.coefficients(&fit);
        let system = fit.problem.system();
        let at_foot = model.at_foot(fit);
        let contact = model.contact(&at_foot);
        let [residual, iterations] = model.foot_figures(at_foot.root);
        self.scalar("gap", "Signed gap g, length, positive apart (eq. 19)", contact.gap);
        self.array("foot", "Foot point x^d, global axes, length", &contact.foot.0);
        self.array("normal", "Unit normal ν at the foot, global axes (eq. 22)", &contact.normal.0);
        self.array(
            "coefficients",
            "Coefficients α about the slave, units length, 1, 1, 1/length, … (eq. 13)",
            &alpha,
        );
        let problem = &at_foot.fit.problem;
        if spec.output == Output::Slip {
            let slip = model.slip(&at_foot);
            self.scalar("slip", "q = ½ |P_ν d|², half the square of the slip, length²", slip.half_square);
            if spec.mode >= Mode::Gradient {
                self.node_value("foot_weights", slip.foot_weight);
            }
            self.derivatives(
                spec.mode,
                problem,
                &[("gap", contact.functional), ("slip", slip.functional)],
                2,
            );
            self.equations.extend([
                Equation {
                    formula: "q = |nu x (x^c - x^a)|^2 / 2",
                    source: "slip from the anchor x^a; docs/equations.md, T16",
                },
                Equation {
                    formula: "x^d = sum phi_k x_k",
                    source: "the foot as an affine combination; docs/equations.md, T15",
                },
            ]);
        } else {
            self.derivatives(spec.mode, problem, &[("gap", contact.functional)], 1);
            if let Some((_, hessian)) = self.hessians.first() {
                let quantities = model.foot_quantities(&at_foot).into_iter();
                let combination = |FootQuantity { name, by_alpha, by_theta }: FootQuantity<'_>| {
                    (name, problem.combination(hessian, (&by_alpha, by_theta.as_deref())))
                };
                self.combinations = quantities.map(combination).collect();
            }
        }
        self.pivot_ratio(system);
        if let Some(plane) = model.plane() {
            self.scalar(
                "plane_pivot_ratio",
                "Smallest pivot of the average plane's system, relative",
                plane.system.pivot_ratio(),
            );
            self.equations.extend(match spec.frame {
                FrameRule::Material => vec![
                    Equation {
                        formula: "n minimises sum omega (n (x^i - x_mean))^2",
                        source: "average plane, moving with the nodes; docs/equations.md, T14",
                    },
                    Equation {
                        formula: "sum omega (1 + beta a_k) a_k = 0, sum omega (1 + beta a_k) (X_k - Xi) = 0",
                        source: "the slave's place in the first configuration; docs/equations.md, T18",
                    },
                ],
                FrameRule::Held | FrameRule::CoMoving => vec![Equation {
                    formula: "n minimises sum omega (n (x^i - x_mean))^2, omega = w(reach |x^i - x^c| / R_k)",
                    source: "average plane, moving with the nodes; docs/equations.md, T14",
                }],
            });
        }
        self.scalar(
            "foot_residual",
            "Largest foot residual |−u_k + h f_k|, relative to the starting one or R",
            residual,
        );
        self.scalar("foot_iterations", "Newton iterations for the foot", iterations);
        self.scalar("foot_distance", "In-plane distance of the foot from the slave over R", contact.distance);
        self.scalar(
            "jacobian_determinant",
            "det J of the foot equations, 0 on a centre of curvature",
            contact.determinant,
        );
        self.scalar(
            "jacobian_trace",
            "tr J, negative where the foot is the nearest point around it",
            contact.trace,
        );
        self.equations.extend([
            Equation { formula: "-u_k + h f_k = 0, h = -f(u)", source: "foot point x^d" },
            Equation { formula: "g = nu (x^c - x^d)", source: "Chamoret et al. 2008, eq. 19" },
            Equation {
                formula: "nu = (-f_1, -f_2, 1) / sqrt(1 + f_1^2 + f_2^2)",
                source: "Chamoret et al. 2008, eq. 22",
            },
            Equation { formula: "N = dg/dx, M = d2g/dx2", source: "Chamoret et al. 2008, eqs. 32 and 42" },
        ]);
    }

    /// Gradients of all functionals and Hessians of the first `hessians`, as far as the mode asks for them.
    fn derivatives<'g>(
        &mut self,
        mode: Mode,
        problem: &NodeProblem<'g>,
        functionals: &[(&'static str, Functional<'g>)],
        hessians: usize,
    ) {
        if mode >= Mode::Gradient {
            self.gradients = functionals.iter().map(|(name, f)| (*name, problem.gradient(f))).collect();
        }
        if mode >= Mode::Hessian {
            let functionals = functionals[..hessians].iter();
            self.hessians = functionals.map(|(name, f)| (*name, problem.hessian(f))).collect();
        }
    }

    fn pivot_ratio(&mut self, system: System<'_>) {
        self.scalar(
            "pivot_ratio",
            "Smallest pivot of A relative to its diagonal, 0 for a singular fit",
            system.pivot_ratio(),
        );
    }

    /// A sum that is finite only if all results are, but for the Hessian: the slave's gradient is the sum of the masters' as they are
    /// written. The emitted kernel adds what `finish_form` says of the entries it wrote.
    fn checksum(&mut self, sheet: &Sheet) {
        let mut terms: Vec<ExprId> = self.values.iter().flat_map(|v| v.components.clone()).collect();
        terms.extend(self.gradients.iter().flat_map(|(_, gradient)| gradient.slave));
        terms.extend(self.node_values.iter().map(|&(_, x)| sheet.expr(x).sum().id()));
        self.scalar(CHECKSUM, "Finite only if every result is", total(sheet.exprs(terms)));
    }

    pub(super) fn scalar(&mut self, name: &'static str, doc: &'static str, value: Expr<'_>) {
        let components = vec![value.named(name).id()];
        self.values.push(Value { name: name.into(), doc: doc.into(), is_array: false, components });
    }

    fn node_value(&mut self, name: &'static str, value: Expr<'_>) {
        self.node_values.push((name, value.named(name).id()));
    }

    pub(super) fn array(&mut self, name: &'static str, doc: &'static str, components: &[Expr<'_>]) {
        let named = |(k, x): (usize, &Expr<'_>)| x.named(&format!("{name}_{k}")).id();
        let components = components.iter().enumerate().map(named).collect();
        self.values.push(Value { name: name.into(), doc: doc.into(), is_array: true, components });
    }
}
