
#ifndef DIFFUSE_CONTACT_TWO_VARIABLES
#define DIFFUSE_CONTACT_TWO_VARIABLES
/* H^-1 r with H = -J where that is positive definite; elsewhere with the absolute values of its eigenvalues, none of which is taken for
   zero. */
static inline void diffuse_contact_downhill_step(const double r[2], const double j[4], double step[2]) {
    const double off = -0.5 * (j[1] + j[2]), mean = -0.5 * (j[0] + j[3]), difference = 0.5 * (j[3] - j[0]);
    const double radius = sqrt(difference * difference + off * off), smallest = mean - radius;
    const double along[2] = {difference * r[0] + off * r[1], off * r[0] - difference * r[1]};
    const double largest = fabs(mean + radius), least = 1e-3 * largest;
    const double other = fabs(smallest) < least ? least : fabs(smallest);
    const double reciprocal = 1.0 / (j[0] * j[3] - j[1] * j[2]);
    const double newton[2] = {(j[1] * r[1] - j[3] * r[0]) * reciprocal, (j[2] * r[0] - j[0] * r[1]) * reciprocal};
    for (int k = 0; k < 2; k++) {
        const double deviation = 0.0 < fabs(radius) ? along[k] / radius : 0.0;
        const double downhill = 0.5 * (r[k] + deviation) / largest + 0.5 * (r[k] - deviation) / other;
        step[k] = 0.0 < smallest ? newton[k] : downhill;
    }
}

static inline double diffuse_contact_longest(const double y[2]) { return 0.5 * diffuse_contact_norm(2, y) + 0.5; }

/* A step down to a minimum of the function whose negative derivatives the residuals are. It is cut to 1/2 and half of the way already made,
   and halved until it does not overshoot, or shortens the way by the same matrix. */
static inline int diffuse_contact_descend(diffuse_contact_equations *at, const double *residual, const double *jacobian) {
    const int is_first = at->evaluations == 0, is_active = !(at->relative < 1e-12);
    int is_accepted = is_first;
    double full[2];
    if (!is_first) {
        const double before = at->step[0] * at->residual[0] + at->step[1] * at->residual[1];
        const double after = at->step[0] * residual[0] + at->step[1] * residual[1];
        double rest[2];
        diffuse_contact_downhill_step(at->residual, at->jacobian, full);
        diffuse_contact_downhill_step(residual, at->jacobian, rest);
        is_accepted = is_active && (-0.5 * before < after || diffuse_contact_norm(2, rest) <
                                                                  diffuse_contact_norm(2, full) - 0.5 * diffuse_contact_norm(2, at->step));
    }
    if (is_accepted) {
        for (int k = 0; k < 2; k++) at->y[k] += at->step[k], at->residual[k] = residual[k];
        for (int k = 0; k < 4; k++) at->jacobian[k] = jacobian[k];
        diffuse_contact_downhill_step(residual, jacobian, full);
        const double length = diffuse_contact_norm(2, full), longest = diffuse_contact_longest(at->y);
        const double factor = longest < length ? longest / length : 1.0;
        for (int k = 0; k < 2; k++) at->step[k] = factor * full[k];
    } else {
        for (int k = 0; k < 2; k++) at->step[k] *= 0.5;
    }
    if (is_first) {
        for (int k = 0; k < 2; k++) at->start[k] = residual[k];
    } else {
        at->iterations += is_active;
    }
    if (!diffuse_contact_is_over(at, full)) return 0;
    /* A singular Jacobian allows no last step. */
    const int is_short = diffuse_contact_norm(2, full) < diffuse_contact_longest(at->y);
    for (int k = 0; k < 2 && is_short; k++) at->y[k] += full[k];
    return 1;
}
#endif
