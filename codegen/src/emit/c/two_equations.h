
#ifndef DIFFUSE_CONTACT_TWO_EQUATIONS
#define DIFFUSE_CONTACT_TWO_EQUATIONS
/* A damped Newton iteration for two equations r(y) = 0 from y = 0, one evaluation of r and its Jacobian at a time. A step is cut to 1/2,
   and halved until it reduces the residual. */
typedef struct {
    double y[2], residual[2], jacobian[4], start[2], step[2];
    /* Squares of what is compared, in units of the start, must not underflow. */
    double unit;
    /* Largest residual before the last step, over the starting one or y, whichever is larger, or 1e-6 of the last step by the same
       measure. Not below 1e-12 if there is no root. */
    double relative;
    int iterations, evaluations;
} diffuse_contact_two_equations;

static inline double diffuse_contact_larger(double x, double y) { return x < y ? y : x; }

static inline double diffuse_contact_norm(const double x[2]) { return diffuse_contact_larger(fabs(x[0]), fabs(x[1])); }

static inline double diffuse_contact_squared(double unit, const double x[2]) {
    return unit * x[0] * (unit * x[0]) + unit * x[1] * (unit * x[1]);
}

/* -J^-1 r */
static inline void diffuse_contact_newton_step(const diffuse_contact_two_equations *at, double step[2]) {
    const double *r = at->residual, *j = at->jacobian, reciprocal = 1.0 / (j[0] * j[3] - j[1] * j[2]);
    step[0] = (j[1] * r[1] - j[3] * r[0]) * reciprocal;
    step[1] = (j[2] * r[0] - j[0] * r[1]) * reciprocal;
}

static inline void diffuse_contact_begin(diffuse_contact_two_equations *at) {
    for (int k = 0; k < 2; k++) at->y[k] = at->step[k] = at->residual[k] = at->start[k] = 0.0;
    for (int k = 0; k < 4; k++) at->jacobian[k] = 0.0;
    at->unit = at->relative = 1.0;
    at->iterations = 1;
    at->evaluations = 0;
}

/* Counts the evaluation; whether it was the last one. `step` becomes Newton's. */
static inline int diffuse_contact_is_over(diffuse_contact_two_equations *at, double step[2]) {
    at->evaluations++;
    diffuse_contact_newton_step(at, step);
    at->relative = diffuse_contact_larger(diffuse_contact_norm(step) * (1e-12 / 1e-6), diffuse_contact_norm(at->residual)) /
                   diffuse_contact_larger(diffuse_contact_norm(at->start) + 1e-290, diffuse_contact_norm(at->y));
    return at->evaluations >= 60 || at->relative < 1e-12;
}

/* Takes the residuals at y + step and their Jacobian, row by row; returns whether this was the last evaluation. */
static inline int diffuse_contact_advance(diffuse_contact_two_equations *at, double r1, double r2, double j11, double j12, double j21,
                                          double j22) {
    const double residual[2] = {r1, r2}, jacobian[4] = {j11, j12, j21, j22};
    const int is_first = at->evaluations == 0, is_active = !(at->relative < 1e-12);
    const int is_accepted = is_first || (is_active && diffuse_contact_squared(at->unit, residual) <
                                                          diffuse_contact_squared(at->unit, at->residual));
    double step[2];
    if (is_accepted) {
        for (int k = 0; k < 2; k++) at->y[k] += at->step[k], at->residual[k] = residual[k];
        for (int k = 0; k < 4; k++) at->jacobian[k] = jacobian[k];
        diffuse_contact_newton_step(at, step);
        const double length = diffuse_contact_norm(step), factor = 0.5 < length ? 0.5 / length : 1.0;
        for (int k = 0; k < 2; k++) at->step[k] = factor * step[k];
    } else {
        for (int k = 0; k < 2; k++) at->step[k] *= 0.5;
    }
    if (is_first) {
        at->unit = 1.0 / (diffuse_contact_norm(residual) + 1e-290);
        for (int k = 0; k < 2; k++) at->start[k] = residual[k];
    } else {
        at->iterations += is_active;
    }
    if (!diffuse_contact_is_over(at, step)) return 0;
    /* One that has not converged takes no last step, as from a singular Jacobian. */
    for (int k = 0; k < 2 && at->relative < 1e-12; k++) at->y[k] += step[k];
    return 1;
}
#endif
