//! Constructors of expressions and the local simplifications they apply.
//!
//! Each rule is one function with the rule as its comment and one unit test. Nothing is expanded, and no factor is cancelled from a
//! quotient. Products and sums may be put into another order where that removes work: of sums whose terms cancel, other digits are lost then.
//! A named product or a definition keeps its own order. But for that a result is at least as accurate as what it replaces, wherever no
//! product on the way overflows or underflows: numbers are multiplied with one another first.

use super::{ExprId, Function, Graph, Op, Scope};

/// Sums with more terms than this are left as they are.
const MOST_TERMS_TO_COLLECT: usize = 12;
/// Products with more factors than this are not looked up by their factors.
const MOST_FACTORS: usize = 16;
/// Real exponents that are integers up to this size are repeated products.
const MOST_PRODUCTS: f64 = 32.0;

impl Graph {
    /// An operation of this graph on these operands in the place of its own, in their order.
    ///
    /// # Panics
    /// If it has others, or none.
    pub(crate) fn made(&mut self, op: Op, operands: &[ExprId]) -> ExprId {
        match (op, operands) {
            (Op::Add(..), &[x, y]) => self.add(x, y),
            (Op::Neg(_), &[x]) => self.neg(x),
            (Op::Mul(..), &[x, y]) => self.mul(x, y),
            (Op::Div(..), &[x, y]) => self.div(x, y),
            (Op::DivOrZero(..), &[x, y]) => self.div_or_zero(x, y),
            (Op::Sqrt(_), &[x]) => self.sqrt(x),
            (Op::Exp(_), &[x]) => self.exp(x),
            (Op::Function(function, _), &[x]) => self.function(function, x),
            (Op::Atan2(..), &[y, x]) => self.atan2(y, x),
            (Op::RealPower(..), &[x, y]) => self.real_power(x, y),
            (Op::Hypot(..), &[x, y]) => self.hypot(x, y),
            (Op::Power(_, exponent), &[x]) => self.power(x, exponent),
            (Op::Polynomial(_, polynomial), &[x]) => {
                let polynomial = self.polynomial_data(polynomial).clone();
                self.polynomial(x, polynomial)
            }
            (Op::Select { .. }, &[x, y, then, otherwise]) => self.select_less(x, y, then, otherwise),
            (Op::Sum(_), &[x]) => self.sum(x),
            _ => panic!("{op:?} has other operands"),
        }
    }

    /// A number.
    pub fn constant(&mut self, value: f64) -> ExprId {
        // −0 and 0 are one constant.
        self.intern(Op::Constant((value + 0.0).to_bits()))
    }

    /// 0
    pub fn zero(&mut self) -> ExprId {
        self.constant(0.0)
    }

    /// 1
    pub fn one(&mut self) -> ExprId {
        self.constant(1.0)
    }

    /// The number an expression is, if it is a constant.
    pub fn constant_value(&self, expr: ExprId) -> Option<f64> {
        match self.op(expr) {
            Op::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// Whether an expression is the constant 0.
    pub fn is_zero(&self, expr: ExprId) -> bool {
        self.constant_value(expr) == Some(0.0)
    }

    /// Whether an expression is the constant 1.
    pub fn is_one(&self, expr: ExprId) -> bool {
        self.constant_value(expr) == Some(1.0)
    }

    /// x + y
    pub fn add(&mut self, x: ExprId, y: ExprId) -> ExprId {
        if let Some(sum) = self.fold_add(x, y).or_else(|| self.drop_zero_term(x, y)) {
            return sum;
        }
        if self.is_as_written {
            return self.intern(Op::Add(x, y));
        }
        self.collect_like_terms(x, y)
            .or_else(|| self.pull_out_common_sign(x, y))
            .or_else(|| self.factor_out(x, y))
            .or_else(|| self.chain_products(x, y))
            .unwrap_or_else(|| self.intern(Op::Add(x.min(y), x.max(y))))
    }

    /// x − y
    pub fn sub(&mut self, x: ExprId, y: ExprId) -> ExprId {
        let minus_y = self.neg(y);
        self.add(x, minus_y)
    }

    /// −x
    pub fn neg(&mut self, x: ExprId) -> ExprId {
        if self.is_as_written && self.constant_value(x).is_none() {
            return self.intern(Op::Neg(x));
        }
        // −(−x) → x, −(c x) → (−c) x
        let minus_one = self.constant(-1.0);
        self.mul(minus_one, x)
    }

    /// x y
    pub fn mul(&mut self, x: ExprId, y: ExprId) -> ExprId {
        if self.is_as_written {
            return self.mul_as_written(x, y);
        }
        let (coefficient, factors) = self.merged_factors(x, y);
        if coefficient == 0.0 {
            // 0 x → 0: zeros here are structural (a derivative that does not exist), not rounded values.
            return self.zero();
        }
        if let Some(place) = self.first_square_of_norm(&factors) {
            // h h → h² for a norm h, or one over something, which has derivatives at the origin
            let square = self.power(factors[place], 2);
            let number = self.constant(coefficient);
            let others = factors[..place].iter().chain(&factors[place + 2..]);
            let others = others.fold(number, |product, &factor| self.mul(product, factor));
            return self.mul(others, square);
        }
        let core = if factors.is_empty() {
            return self.constant(coefficient);
        } else if let Some(&known) = self.products.get(&factors) {
            known
        } else {
            let (x, y) = (self.without_coefficient(x), self.without_coefficient(y));
            let product = match (self.is_one(x), self.is_one(y)) {
                (true, _) => y,
                (_, true) => x,
                _ => self.intern(Op::Mul(x.min(y), x.max(y))),
            };
            if factors.len() <= MOST_FACTORS {
                self.products.insert(factors, product);
            }
            product
        };
        self.scaled(coefficient, core)
    }

    fn mul_as_written(&mut self, x: ExprId, y: ExprId) -> ExprId {
        match (self.constant_value(x), self.constant_value(y)) {
            (Some(x), Some(y)) => self.constant(x * y),
            (Some(0.0), _) | (_, Some(0.0)) => self.zero(),
            (Some(1.0), _) => y,
            (_, Some(1.0)) => x,
            // Else it has no derivatives where it is zero.
            _ if x == y && self.is_norm(x) => self.power(x, 2),
            _ => self.intern(Op::Mul(x, y)),
        }
    }

    /// Where a norm stands twice among sorted factors.
    fn first_square_of_norm(&self, factors: &[ExprId]) -> Option<usize> {
        factors.windows(2).position(|pair| pair[0] == pair[1] && self.is_norm(pair[0]))
    }

    /// Whether it is a norm, or something with that as a factor over something.
    fn is_norm(&self, x: ExprId) -> bool {
        match self.op(x) {
            Op::Hypot(..) => true,
            Op::Div(x, _) => self.has_norm(x),
            _ => false,
        }
    }

    /// Whether a factor of it is a norm, so that its square has derivatives where it is zero, and it has none.
    pub(crate) fn has_norm(&self, x: ExprId) -> bool {
        self.coefficient_and_factors(x).1.iter().any(|&factor| self.is_norm(factor))
    }

    /// x / y
    pub fn div(&mut self, x: ExprId, y: ExprId) -> ExprId {
        if self.is_zero(x) {
            return x; // 0 / y → 0, structural
        }
        match self.constant_value(y) {
            Some(1.0) => return x, // x / 1 → x
            _ if self.is_as_written => return self.intern(Op::Div(x, y)),
            // x / 2ᵏ → 2⁻ᵏ x, exact
            Some(c) if c.is_normal() && c.to_bits().trailing_zeros() >= 52 => {
                let reciprocal = self.constant(1.0 / c);
                return self.mul(reciprocal, x);
            }
            Some(c) => {
                if let Some(x) = self.constant_value(x) {
                    return self.constant(x / c); // fold
                }
            }
            None => {}
        }
        let (coefficient, _) = self.coefficient_and_factors(x);
        let core = self.without_coefficient(x);
        if coefficient != 1.0 && !self.is_one(core) {
            // (c x) / y → c (x / y)
            let quotient = self.intern(Op::Div(core, y));
            return self.scaled(coefficient, quotient);
        }
        self.intern(Op::Div(x, y))
    }

    /// x / y, and 0 where y = 0.
    pub fn div_or_zero(&mut self, x: ExprId, y: ExprId) -> ExprId {
        if self.is_zero(x) {
            return x;
        }
        // x / y → x (1 / y): the reciprocal of a norm serves all its components
        let one = self.one();
        let reciprocal = self.intern(Op::DivOrZero(one, y));
        self.mul(x, reciprocal)
    }

    /// √x
    pub fn sqrt(&mut self, x: ExprId) -> ExprId {
        match self.constant_value(x) {
            Some(value) if value >= 0.0 => self.constant(value.sqrt()),
            _ => self.intern(Op::Sqrt(x)),
        }
    }

    /// eˣ
    pub fn exp(&mut self, x: ExprId) -> ExprId {
        match self.constant_value(x) {
            Some(value) => self.constant(value.exp()),
            _ => self.intern(Op::Exp(x)),
        }
    }

    /// f(x)
    pub fn function(&mut self, function: Function, x: ExprId) -> ExprId {
        if let Some(value) = self.constant_value(x) {
            return self.constant(function.evaluate(value));
        }
        match (function, self.op(x)) {
            _ if self.is_as_written => self.intern(Op::Function(function, x)),
            // ln(eˣ) → x
            (Function::Ln, Op::Exp(inner)) => inner,
            // cos(−x) → cos(x)
            (Function::Cos, Op::Neg(inner)) => self.intern(Op::Function(function, inner)),
            // sin(−x) → −sin(x), ∛(−x) → −∛x
            (Function::Sin | Function::Cbrt, Op::Neg(inner)) => {
                let positive = self.intern(Op::Function(function, inner));
                self.neg(positive)
            }
            _ => self.intern(Op::Function(function, x)),
        }
    }

    /// Angle of the point (x, y) in (−π, π].
    pub fn atan2(&mut self, y: ExprId, x: ExprId) -> ExprId {
        match (self.constant_value(y), self.constant_value(x)) {
            (Some(y), Some(x)) => self.constant(y.atan2(x)),
            _ => self.intern(Op::Atan2(y, x)),
        }
    }

    /// xʸ for x > 0; for a small integer y that of any x.
    pub fn real_power(&mut self, x: ExprId, y: ExprId) -> ExprId {
        match (self.constant_value(x), self.constant_value(y)) {
            (Some(x), Some(y)) => self.constant(x.powf(y)),
            // x^½ → √x
            (None, Some(0.5)) => self.sqrt(x),
            // An integer exponent → repeated products
            _ => match self.integer_exponent(y) {
                Some(exponent) => self.power(x, exponent),
                None => self.intern(Op::RealPower(x, y)),
            },
        }
    }

    /// The exponent of a power by repeated products, if it is one.
    pub(crate) fn integer_exponent(&self, y: ExprId) -> Option<i32> {
        self.constant_value(y).filter(|y| y.fract() == 0.0 && y.abs() <= MOST_PRODUCTS).map(|y| y as i32)
    }

    /// √(x² + y²)
    pub fn hypot(&mut self, x: ExprId, y: ExprId) -> ExprId {
        self.intern(Op::Hypot(x, y))
    }

    /// xᵏ
    pub fn power(&mut self, x: ExprId, exponent: i32) -> ExprId {
        if let Some(value) = self.constant_value(x) {
            return self.constant(value.powi(exponent));
        }
        match (exponent, self.op(x)) {
            (0, _) => self.one(),
            (1, _) => x,
            // (√(a² + b²))² → a² + b², where a may be a norm itself
            (2, Op::Hypot(a, b)) => {
                let (aa, bb) = (self.power(a, 2), self.power(b, 2));
                self.add(aa, bb)
            }
            // (h / y)² → h² / y² for a norm h
            (2, Op::Div(h, y)) if self.is_norm(x) => {
                let (hh, yy) = (self.mul(h, h), self.mul(y, y));
                self.div(hh, yy)
            }
            // (√q)²ᵏ → qᵏ: its derivatives are finite where q is 0
            (_, Op::Sqrt(square)) if exponent > 0 && exponent % 2 == 0 => self.power(square, exponent / 2),
            (2, _) => self.mul(x, x),
            // (xʲ)ᵏ → xʲᵏ for integers
            (_, Op::Power(base, inner)) if !self.is_as_written => match inner.checked_mul(exponent) {
                Some(product) => self.power(base, product),
                None => self.intern(Op::Power(x, exponent)),
            },
            _ => self.intern(Op::Power(x, exponent)),
        }
    }

    /// Sum over the nodes of a node expression.
    pub fn sum(&mut self, x: ExprId) -> ExprId {
        if self.is_zero(x) {
            return x;
        }
        if self.scope(x) == Scope::Element {
            let count = self.node_count();
            return self.mul(count, x); // Σ c → n c
        }
        if self.is_as_written {
            return self.intern(Op::Sum(x));
        }
        // Σ c x → c Σ x
        let (coefficient, _) = self.coefficient_and_factors(x);
        let core = self.without_coefficient(x);
        let sum = self.intern(Op::Sum(core));
        self.scaled(coefficient, sum)
    }

    /// x · y for two vectors of equal length.
    pub fn dot(&mut self, x: &[ExprId], y: &[ExprId]) -> ExprId {
        assert_eq!(x.len(), y.len(), "a dot product needs vectors of equal length");
        let terms: Vec<ExprId> = x.iter().zip(y).map(|(&x, &y)| self.mul(x, y)).collect();
        // What is no product goes first: every product after it fuses with its addition.
        let (products, others): (Vec<ExprId>, Vec<ExprId>) =
            terms.into_iter().partition(|&term| self.is_product(term));
        let start = self.total(&others);
        products.into_iter().fold(start, |total, product| self.add(total, product))
    }

    fn is_product(&self, x: ExprId) -> bool {
        matches!(self.op(self.without_sign(x)), Op::Mul(..))
    }

    /// Sum of several terms, added from the left.
    pub fn total(&mut self, terms: &[ExprId]) -> ExprId {
        let zero = self.zero();
        terms.iter().fold(zero, |total, &term| self.add(total, term))
    }

    /// c₁ + c₂ → their sum
    fn fold_add(&mut self, x: ExprId, y: ExprId) -> Option<ExprId> {
        let value = self.constant_value(x)? + self.constant_value(y)?;
        Some(self.constant(value))
    }

    /// x + 0 → x
    fn drop_zero_term(&self, x: ExprId, y: ExprId) -> Option<ExprId> {
        if self.is_zero(x) {
            Some(y)
        } else if self.is_zero(y) {
            Some(x)
        } else {
            None
        }
    }

    /// x + (p + q) → (x + p) + q for products p, q: two fused additions instead of three operations
    fn chain_products(&mut self, x: ExprId, y: ExprId) -> Option<ExprId> {
        for (start, sum) in [(x, y), (y, x)] {
            let Op::Add(p, q) = self.op(sum) else { continue };
            let products = self.is_product(p) && self.is_product(q) && !self.is_product(start);
            if products && self.name_of(sum).is_none() {
                let first = self.add(start, p);
                return Some(self.add(first, q));
            }
        }
        None
    }

    /// c x y + d x → x (c y + d) for numbers c, d
    fn factor_out(&mut self, x: ExprId, y: ExprId) -> Option<ExprId> {
        let (c, long) = self.coefficient_and_factors(x);
        let (d, short) = self.coefficient_and_factors(y);
        let (c, d, mut long, short) =
            if long.len() > short.len() { (c, d, long, short) } else { (d, c, short, long) };
        // With a bare ±1 for both numbers nothing is saved, and x y is often there already.
        if short.is_empty() || long.len() == short.len() || (c.abs() == 1.0 && d.abs() == 1.0) {
            return None;
        }
        for factor in &short {
            let position = long.iter().position(|other| other == factor)?;
            long.remove(position);
        }
        let one = self.one();
        let rest = long.into_iter().fold(one, |product, x| self.mul(product, x));
        let (rest, number) = (self.scaled(c, rest), self.constant(d));
        let sum = self.add(rest, number);
        let common = short.into_iter().fold(one, |product, x| self.mul(product, x));
        Some(self.mul(common, sum))
    }

    /// c₁ x + c₂ x → (c₁ + c₂) x, also where the two stand in longer sums; x − x → 0.
    fn collect_like_terms(&mut self, x: ExprId, y: ExprId) -> Option<ExprId> {
        if x == y {
            let two = self.constant(2.0);
            return Some(self.mul(two, x));
        }
        let mut terms: Vec<(f64, ExprId)> = Vec::new();
        self.append_terms(x, 1.0, &mut terms);
        let left = terms.len();
        self.append_terms(y, 1.0, &mut terms);
        if terms.len() > MOST_TERMS_TO_COLLECT {
            return None;
        }
        let shared =
            terms[left..].iter().any(|(_, core)| terms[..left].iter().any(|(_, other)| other == core));
        if !shared {
            return None;
        }
        let mut collected: Vec<(f64, ExprId)> = Vec::new();
        for (coefficient, core) in terms {
            match collected.iter_mut().find(|(_, other)| *other == core) {
                Some((total, _)) => *total += coefficient,
                None => collected.push((coefficient, core)),
            }
        }
        let zero = self.zero();
        Some(collected.into_iter().fold(zero, |total, (coefficient, core)| {
            let term = self.scaled(coefficient, core);
            self.add(total, term)
        }))
    }

    /// −x − y → −(x + y)
    fn pull_out_common_sign(&mut self, x: ExprId, y: ExprId) -> Option<ExprId> {
        let (Op::Neg(x), Op::Neg(y)) = (self.op(x), self.op(y)) else { return None };
        let sum = self.add(x, y);
        Some(self.neg(sum))
    }

    fn append_terms(&self, x: ExprId, sign: f64, terms: &mut Vec<(f64, ExprId)>) {
        match self.op(x) {
            // A named sum is a quantity of the model: it is kept whole.
            Op::Add(left, right) if self.name_of(x).is_none() && terms.len() <= MOST_TERMS_TO_COLLECT => {
                self.append_terms(left, sign, terms);
                self.append_terms(right, sign, terms);
            }
            Op::Neg(inner) => self.append_terms(inner, -sign, terms),
            Op::Mul(..) => {
                let (coefficient, _) = self.coefficient_and_factors(x);
                match self.core(x) {
                    Some(core) => terms.push((sign * coefficient, core)),
                    None => terms.push((sign, x)),
                }
            }
            _ => terms.push((sign, x)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::three_inputs as graph;
    use super::*;

    #[test]
    fn constants_are_folded() {
        let mut g = Graph::new();
        let (two, three) = (g.constant(2.0), g.constant(3.0));
        let results =
            [g.add(two, three), g.mul(two, three), g.div(two, three), g.power(three, -2), g.exp(two)];
        let expected = [5.0, 6.0, 2.0 / 3.0, 1.0 / 9.0, 2f64.exp()];
        assert_eq!(results.map(|id| g.constant_value(id).unwrap()), expected);
        let four = g.constant(4.0);
        let root = g.sqrt(four);
        assert_eq!(g.constant_value(root), Some(2.0));
    }

    #[test]
    fn functions_of_numbers_are_folded_and_signs_come_out_of_them() {
        let (mut g, x, y, _) = graph();
        let [two, half] = [2.0, 0.5].map(|number| g.constant(number));
        let folded = [g.function(Function::Ln, two), g.atan2(two, half), g.real_power(two, half)];
        let expected = [2f64.ln(), 2f64.atan2(0.5), 2f64.powf(0.5)];
        assert_eq!(folded.map(|id| g.constant_value(id).unwrap()), expected);
        let (minus_x, exponential) = (g.neg(x), g.exp(y));
        for function in [Function::Sin, Function::Cbrt] {
            let (negative, positive) = (g.function(function, minus_x), g.function(function, x));
            assert_eq!(negative, g.neg(positive));
        }
        assert_eq!(g.function(Function::Cos, minus_x), g.function(Function::Cos, x));
        assert_eq!(g.function(Function::Ln, exponential), y);
    }

    #[test]
    fn a_real_power_with_an_exact_exponent_needs_no_logarithm() {
        let (mut g, x, y, _) = graph();
        let [half, minus_three, third] = [0.5, -3.0, 1.0 / 3.0].map(|number| g.constant(number));
        assert_eq!(g.real_power(x, half), g.sqrt(x));
        assert_eq!(g.real_power(x, minus_three), g.power(x, -3));
        for exponent in [third, y] {
            let power = g.real_power(x, exponent);
            assert_eq!(g.op(power), Op::RealPower(x, exponent));
        }
    }

    #[test]
    fn zero_terms_and_unit_factors_vanish() {
        let (mut g, x, ..) = graph();
        let (zero, one) = (g.zero(), g.one());
        assert_eq!(g.add(x, zero), x);
        assert_eq!(g.mul(one, x), x);
        assert_eq!(g.mul(zero, x), zero);
        assert_eq!(g.div(x, one), x);
        assert_eq!(g.div(zero, x), zero);
        assert_eq!(g.div_or_zero(zero, x), zero);
    }

    #[test]
    fn negation_is_an_involution() {
        let (mut g, x, ..) = graph();
        let minus = g.neg(x);
        assert_eq!(g.neg(minus), x);
    }

    #[test]
    fn like_terms_are_collected_inside_sums() {
        let (mut g, x, y, z) = graph();
        let (xy, yz) = (g.add(x, y), g.add(y, z));
        let sum = g.add(xy, yz);
        let two = g.constant(2.0);
        let two_y = g.mul(two, y);
        let x_and_two_y = g.add(x, two_y);
        assert_eq!(sum, g.add(x_and_two_y, z));
        let difference = g.sub(x, x);
        assert!(g.is_zero(difference));
    }

    #[test]
    fn sums_of_products_become_chains() {
        let (mut g, x, y, z) = graph();
        let (xy, yz) = (g.mul(x, y), g.mul(y, z));
        let sum = g.add(xy, yz);
        let chained = g.add(x, sum);
        let first = g.add(x, xy);
        assert_eq!(chained, g.add(first, yz));
    }

    #[test]
    fn a_number_times_a_common_factor_is_factored_out() {
        let (mut g, x, y, _) = graph();
        let (six, minus_six) = (g.constant(6.0), g.constant(-6.0));
        let xy = g.mul(x, y);
        let (left, right) = (g.mul(six, xy), g.mul(minus_six, x));
        let sum = g.add(left, right);
        let six_y = g.mul(six, y);
        let bracket = g.add(six_y, minus_six);
        assert_eq!(sum, g.mul(x, bracket));
    }

    #[test]
    fn a_named_sum_is_kept_whole() {
        let (mut g, x, y, _) = graph();
        let sum = g.add(x, y);
        g.name(sum, "s");
        let again = g.add(sum, x);
        assert_eq!(g.op(again), Op::Add(sum.min(x), sum.max(x)));
    }

    #[test]
    fn a_common_sign_is_pulled_out_of_a_sum() {
        let (mut g, x, y, _) = graph();
        let (minus_x, minus_y) = (g.neg(x), g.neg(y));
        let sum = g.add(minus_x, minus_y);
        let positive = g.add(x, y);
        assert_eq!(g.op(sum), Op::Neg(positive));
    }

    #[test]
    fn division_by_a_power_of_two_is_an_exact_product() {
        let (mut g, x, ..) = graph();
        let (four, quarter, three) = (g.constant(4.0), g.constant(0.25), g.constant(3.0));
        assert_eq!(g.div(x, four), g.mul(quarter, x));
        let third = g.div(x, three);
        assert_eq!(g.op(third), Op::Div(x, three));
    }

    #[test]
    fn a_coefficient_is_pulled_out_of_a_quotient_and_a_sum_over_nodes() {
        let (mut g, x, y, _) = graph();
        let two = g.constant(2.0);
        let two_x = g.mul(two, x);
        let quotient = g.div(two_x, y);
        let plain = g.div(x, y);
        assert_eq!(quotient, g.mul(two, plain));
        let w = g.input("w", Scope::Node);
        let minus_w = g.neg(w);
        let (sum, minus_sum) = (g.sum(w), g.sum(minus_w));
        assert_eq!(g.neg(sum), minus_sum);
    }

    #[test]
    fn powers_are_exact() {
        let (mut g, x, y, _) = graph();
        assert_eq!(g.power(x, 1), x);
        assert_eq!(g.power(x, 2), g.mul(x, x));
        let (cube, r) = (g.power(x, 3), g.hypot(x, y));
        assert_eq!(g.power(cube, -2), g.power(x, -6));
        let (xx, yy) = (g.mul(x, x), g.mul(y, y));
        assert_eq!(g.power(r, 2), g.add(xx, yy));
    }
}
