//! The steps of the search: Broyden's method, a few steps for many slaves side by side, or as many as it takes for one. The latter
//! measures the derivative, and shortens steps.

use diffuse_contact_kernels::support::{Lane, Vector};

use super::equations::{Evaluated, Fitting, Lanes, choose, dot, each, square};
use crate::eigen::symmetric_eigen;
use crate::frame::{LINE_TOLERANCE, THICKNESS_TOLERANCE};
use crate::vector::Vector3;
use crate::{ElementError, Point};

/// Steps of a lane.
const MOST_STEPS: usize = 12;
/// Steps where these were not enough.
const MOST_THOROUGH_STEPS: usize = 60;
/// A step below this fraction of a domain is rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// A place farther than this part of a domain from where its search began is sought once more, from nearby: nodes that only some lists
/// have may have taken part on the way, in the last bits of the answer.
const FAR: f64 = 0.03;
/// Such a search begins in the middle of a cell of this part of a domain, which all lists lead to.
const CELL: f64 = 1.0 / 64.0;
/// Cells are shifted by this part of one: places on round numbers are not on their borders.
const SHIFT: f64 = 0.381_966_011_250_105;
/// Where steps no longer shrink, they have to be below this fraction of a domain.
const STALLED: f64 = 1e-11;
/// A step has to leave less than this part of the residual, or the derivative is measured.
const CONTRACTION: f64 = 0.5;
/// Shortest part of a step.
const SHORTEST: f64 = 1e-3;
/// Differences are taken over this part of a domain.
const DIFFERENCE: f64 = 1e-4;

/// What was found.
pub struct Searched<T> {
    /// 1, or 0.
    pub is_found: T,
    pub place: [T; 3],
    pub normal: [T; 3],
    pub mean: [T; 3],
    pub evaluations: usize,
}

/// What becomes the inverse of the equations' derivative, up to its sign: rows. Close to the surface the step changes as the place does,
/// which is where it begins.
struct Inverse<T>([[T; 3]; 3]);

impl<T: Lane> Inverse<T> {
    const IDENTITY: Self =
        Self([[T::ONE, T::ZERO, T::ZERO], [T::ZERO, T::ONE, T::ZERO], [T::ZERO, T::ZERO, T::ONE]]);

    #[inline(always)]
    fn times(&self, x: [T; 3]) -> [T; 3] {
        each!(i => dot(self.0[i], x))
    }

    /// Broyden's correction: the step changed by `change` when the place moved.
    #[inline(always)]
    fn correct(&mut self, moved: [T; 3], change: [T; 3]) {
        let change = self.times(change);
        let inverse = &mut self.0;
        let row = each!(j => dot([inverse[0][j], inverse[1][j], inverse[2][j]], moved));
        let inverse_length = T::ONE.div_or_zero(dot(moved, change));
        let correction = each!(i => (moved[i] + change[i]) * inverse_length);
        for i in 0..3 {
            for j in 0..3 {
                inverse[i][j] = correction[i].neg_mul_add(row[j], inverse[i][j]);
            }
        }
    }
}

impl<T: Vector> Lanes<'_, T> {
    /// A few steps, and of lanes whose place is [far](FAR) from where they began a few more.
    #[inline(always)]
    pub fn search(&self, fitting: &impl Fitting) -> Searched<T> {
        let zero = [T::ZERO; 3];
        // The first step is taken with the nodes close to the nearest one: lists hold these wherever they were made.
        let first = self.evaluate::<true>(zero, None, fitting);
        let is_step = T::select_less(first.deviation, T::splat(f64::INFINITY), T::ONE, T::ZERO);
        let start = choose(is_step, first.step, zero);
        let found = self.few_steps((start, T::ONE), fitting);
        let found = Searched { evaluations: found.evaluations + 1, ..found };
        let is_far = T::select_less(self.way(found.place, start), T::splat(FAR), T::ZERO, found.is_found);
        if T::all_less(is_far, T::splat(0.5)) {
            return found;
        }
        let middle_of = |lane: usize| {
            let largest = self.near.iter().fold(0.0, |largest: f64, x| largest.max(x.lane(lane).abs()));
            middle_of_cell(found.place.map(|x| x.lane(lane)), largest)
        };
        let middle = [0, 1, 2].map(|axis| T::from_fn(|lane| middle_of(lane)[axis]));
        let again = self.few_steps((middle, is_far), fitting);
        let is_near = T::select_less(self.way(again.place, middle), T::splat(FAR), again.is_found, T::ZERO);
        Searched {
            is_found: T::select_less(T::splat(0.5), is_far, is_near, found.is_found),
            place: choose(is_far, again.place, found.place),
            normal: choose(is_far, again.normal, found.normal),
            mean: choose(is_far, again.mean, found.mean),
            evaluations: found.evaluations + again.evaluations,
        }
    }

    /// The length of a way between two places in the metric of the nearest node.
    #[inline(always)]
    fn way(&self, to: [T; 3], from: [T; 3]) -> T {
        square(self.near, each!(i => to[i] - from[i])).sqrt()
    }

    /// From this place on, of the lanes that are asked for: 1, or 0.
    #[inline(always)]
    fn few_steps(&self, (start, is_asked): ([T; 3], T), fitting: &impl Fitting) -> Searched<T> {
        let mut now = self.evaluate::<false>(start, None, fitting);
        let mut place = start;
        let mut inverse = Inverse::<T>::IDENTITY;
        let converged = T::splat(ROUNDING);
        let mut is_found = T::select_less(now.deviation, converged, T::ONE, T::ZERO);
        let mut is_open = T::select_less(now.deviation, converged, T::ZERO, is_asked);
        let mut evaluations = 1;
        while evaluations < MOST_STEPS + 1 && !T::all_less(is_open, T::splat(0.5)) {
            evaluations += 1;
            let moved = inverse.times(now.step);
            let next = each!(i => place[i] + moved[i]);
            let after = self.evaluate::<false>(next, Some(now.normal), fitting);
            // Accepted where it is much closer; else the place stays, as an answer if it is close.
            let bound = now.deviation * T::splat(CONTRACTION);
            let is_closer = T::select_less(after.deviation, bound, is_open, T::ZERO);
            let is_close = T::select_less(now.deviation, T::splat(STALLED), is_open, T::ZERO);
            is_found = T::select_less(T::splat(0.5), is_close - is_closer, T::ONE, is_found);
            let is_root = T::select_less(after.deviation, converged, is_closer, T::ZERO);
            is_found = T::select_less(T::splat(0.5), is_root, T::ONE, is_found);
            is_open = is_closer - is_root;
            inverse.correct(moved, each!(i => after.step[i] - now.step[i]));
            place = choose(is_closer, next, place);
            now = Evaluated {
                step: choose(is_closer, after.step, now.step),
                deviation: T::select_less(T::splat(0.5), is_closer, after.deviation, now.deviation),
                normal: choose(is_closer, after.normal, now.normal),
                mean: choose(is_closer, after.mean, now.mean),
            };
        }
        Searched { is_found, place, normal: now.normal, mean: now.mean, evaluations }
    }
}

/// The middle of the cell around a place, for the largest entry of a metric.
fn middle_of_cell(place: [f64; 3], largest: f64) -> [f64; 3] {
    let cell = CELL / largest;
    place.map(|x| ((x / cell - SHIFT).floor() + SHIFT + 0.5) * cell)
}

impl Lanes<'_, f64> {
    /// As many steps as it takes, with what is measured on the way.
    pub fn search_thoroughly(&self, fitting: &impl Fitting) -> Result<Searched<f64>, ElementError> {
        let start =
            self.evaluate_thoroughly::<true>([0.0; 3], None, fitting).map_or([0.0; 3], |first| first.step);
        let zero = [0.0; 3];
        let (begun, found) = match self.search_from(start, fitting) {
            Ok(found) => (start, found),
            Err(error) if start == zero => return Err(error),
            // From the nearest node itself.
            Err(_) => (zero, self.search_from(zero, fitting)?),
        };
        let distance = |from: [f64; 3]| square(self.near, each!(i => found.place[i] - from[i])).sqrt();
        if distance(begun) < FAR {
            return Ok(found);
        }
        let near = middle_of_cell(found.place, self.largest_metric());
        Ok(self.search_from(near, fitting).ok().filter(|again| distance(again.place) < FAR).unwrap_or(found))
    }

    /// The same from this place on.
    fn search_from(&self, start: [f64; 3], fitting: &impl Fitting) -> Result<Searched<f64>, ElementError> {
        let mut search = ThoroughSearch { lanes: self, fitting, normal: None, evaluations: 0 };
        let (mut place, mut now) = (start, search.evaluate(start)?);
        let (mut inverse, mut is_measured, mut is_found) = (Inverse::<f64>::IDENTITY, false, false);
        for _ in 0..MOST_THOROUGH_STEPS {
            if now.deviation <= ROUNDING {
                is_found = true;
                break;
            }
            let moved = inverse.times(now.step);
            let next = each!(i => place[i] + moved[i]);
            if let Ok(after) = search.evaluate(next)
                && (after.deviation < CONTRACTION * now.deviation
                    || (now.deviation <= STALLED && is_measured))
            {
                if now.deviation <= STALLED && after.deviation >= now.deviation {
                    is_found = true;
                    break;
                }
                inverse.correct(moved, each!(i => after.step[i] - now.step[i]));
                (place, now) = (next, after);
                continue;
            }
            if now.deviation <= STALLED {
                is_found = true;
                break;
            }
            if is_measured {
                // A shorter step with what is known here.
                (place, now) = search.shortened(place, moved, now.deviation)?;
            }
            // Far from the surface a place moves the projection by more than itself: the derivative is measured.
            inverse = search.measured(place, &now)?;
            is_measured = true;
        }
        if !is_found && !(now.deviation <= STALLED) {
            return Err(ElementError::NotMaterialPlace { deviation: now.deviation });
        }
        let Evaluated { normal, mean, .. } = now;
        Ok(Searched { is_found: 1.0, place, normal, mean, evaluations: search.evaluations + 1 })
    }

    /// One over the order of the shortest half axis of the nearest node's domain.
    fn largest_metric(&self) -> f64 {
        self.near.iter().fold(0.0, |largest, x| x.abs().max(largest))
    }

    /// The equations at a place, also where lanes do not find the average plane.
    fn evaluate_thoroughly<const IS_START: bool>(
        &self,
        place: [f64; 3],
        near: Option<[f64; 3]>,
        fitting: &impl Fitting,
    ) -> Result<Evaluated<f64>, ElementError> {
        let found = self.evaluate::<IS_START>(place, near, fitting);
        if found.deviation.is_finite() {
            return Ok(found);
        }
        let sums = self.sums::<IS_START>(place, fitting);
        let [xx, xy, xz, yy, yz, zz] = sums.scatter();
        let all = symmetric_eigen([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
        let [smallest, middle, largest] = each!(k => all[k].0.max(0.0));
        if !(middle > LINE_TOLERANCE * largest && middle - smallest > THICKNESS_TOLERANCE * largest) {
            let (smallest, middle) =
                if largest > 0.0 { (smallest / largest, middle / largest) } else { (0.0, 0.0) };
            return Err(ElementError::NoAveragePlane { smallest, middle });
        }
        let found = self.with_normal(&sums, all[0].1);
        if found.deviation.is_finite() {
            Ok(found)
        } else {
            Err(ElementError::NotMaterialPlace { deviation: found.deviation })
        }
    }
}

/// One slave's search.
struct ThoroughSearch<'a, F> {
    lanes: &'a Lanes<'a, f64>,
    fitting: &'a F,
    /// The one found last, which the next is near to.
    normal: Option<[f64; 3]>,
    evaluations: usize,
}

impl<F: Fitting> ThoroughSearch<'_, F> {
    fn evaluate(&mut self, place: [f64; 3]) -> Result<Evaluated<f64>, ElementError> {
        self.evaluations += 1;
        let found = self.lanes.evaluate_thoroughly::<false>(place, self.normal, self.fitting)?;
        self.normal = Some(found.normal);
        Ok(found)
    }

    /// The longest of ever shorter parts of a step that comes closer.
    fn shortened(
        &mut self,
        place: [f64; 3],
        step: [f64; 3],
        deviation: f64,
    ) -> Result<([f64; 3], Evaluated<f64>), ElementError> {
        let mut shorter = 0.5;
        while shorter >= SHORTEST {
            let next = each!(i => place[i] + shorter * step[i]);
            if let Ok(after) = self.evaluate(next)
                && after.deviation < deviation
            {
                return Ok((next, after));
            }
            shorter *= 0.5;
        }
        Err(ElementError::NotMaterialPlace { deviation })
    }

    /// The inverse of the derivative by differences. `now`: at the place itself.
    fn measured(&mut self, place: [f64; 3], now: &Evaluated<f64>) -> Result<Inverse<f64>, ElementError> {
        let small = DIFFERENCE / self.lanes.largest_metric();
        let mut columns = [[0.0; 3]; 3];
        for axis in 0..3 {
            let mut beside = place;
            beside[axis] += small;
            let beside = self.evaluate(beside)?;
            columns[axis] = each!(i => (now.step[i] - beside.step[i]) / small);
        }
        inverted(columns).ok_or(ElementError::NotMaterialPlace { deviation: now.deviation })
    }
}

/// The inverse of the matrix with these columns.
fn inverted(columns: [[f64; 3]; 3]) -> Option<Inverse<f64>> {
    let [x, y, z] = columns.map(Vector3::from);
    let rows = [y.cross(&z), z.cross(&x), x.cross(&y)];
    let determinant = x.dot(&rows[0]);
    let inverse = rows.map(|row| Point::from(row / determinant));
    inverse.as_flattened().iter().all(|x| x.is_finite()).then_some(Inverse(inverse))
}
