
#ifndef DIFFUSE_CONTACT_EQUATIONS
#define DIFFUSE_CONTACT_EQUATIONS
/* Functions that make those around them slower where they are inlined. */
#if defined(__GNUC__)
#define DIFFUSE_CONTACT_APART __attribute__((noinline))
#else
#define DIFFUSE_CONTACT_APART
#endif

/* A damped Newton iteration for one to eight equations r(y) = 0 from y = 0, one evaluation of r and its Jacobian, row by row, at a time. A
   step is cut to a length, and halved until it reduces the residual. */
typedef struct {
    double y[8], residual[8], jacobian[64], start[8], step[8];
    /* Longest step. */
    double longest;
    /* Squares of what is compared, in units of the start, must not underflow. */
    double unit;
    /* Largest residual before the last step, over the starting one or y, whichever is larger, or 1e-6 of the last step by the same
       measure. Not below 1e-12 if there is no root, infinite where there was no number. */
    double relative;
    int size, iterations, evaluations, most;
} diffuse_contact_equations;

static inline double diffuse_contact_larger(double x, double y) { return x < y ? y : x; }

/* Largest absolute component; NaN if one is not finite. */
static inline double diffuse_contact_norm(int size, const double *x) {
    double largest = fabs(x[size - 1]), zero = 0.0 * x[size - 1];
    for (int k = size - 2; k >= 0; k--) {
        largest = diffuse_contact_larger(fabs(x[k]), largest);
        zero += 0.0 * x[k];
    }
    return zero + largest;
}

static inline double diffuse_contact_squared(int size, double unit, const double *x) {
    double sum = unit * x[0] * (unit * x[0]);
    for (int k = 1; k < size; k++) sum += unit * x[k] * (unit * x[k]);
    return sum;
}

/* -J^-1 r: of two equations by determinants, of others by elimination with the largest pivots. */
DIFFUSE_CONTACT_APART static void diffuse_contact_newton_step(const diffuse_contact_equations *at, double *step) {
    const double *r = at->residual, *j = at->jacobian;
    const int size = at->size;
    if (size == 2) {
        const double reciprocal = 1.0 / (j[0] * j[3] - j[1] * j[2]);
        step[0] = (j[1] * r[1] - j[3] * r[0]) * reciprocal;
        step[1] = (j[2] * r[0] - j[0] * r[1]) * reciprocal;
        return;
    }
    double a[8][9];
    for (int i = 0; i < size; i++) {
        for (int k = 0; k < size; k++) a[i][k] = j[i * size + k];
        a[i][size] = -r[i];
    }
    for (int k = 0; k < size; k++) {
        for (int i = k + 1; i < size; i++) {
            for (int c = k, exchange = fabs(a[k][k]) < fabs(a[i][k]); exchange && c <= size; c++) {
                const double x = a[k][c];
                a[k][c] = a[i][c];
                a[i][c] = x;
            }
        }
        for (int i = k + 1; i < size; i++) {
            const double factor = a[i][k] / a[k][k];
            for (int c = k + 1; c <= size; c++) a[i][c] -= factor * a[k][c];
        }
    }
    for (int k = size - 1; k >= 0; k--) {
        double rest = a[k][size];
        for (int c = k + 1; c < size; c++) rest -= a[k][c] * step[c];
        step[k] = rest / a[k][k];
    }
}

static inline void diffuse_contact_begin(diffuse_contact_equations *at, int size, double longest, int most) {
    for (int k = 0; k < size; k++) at->y[k] = at->step[k] = at->residual[k] = at->start[k] = 0.0;
    for (int k = 0; k < size * size; k++) at->jacobian[k] = 0.0;
    at->longest = longest;
    at->unit = at->relative = 1.0;
    at->size = size;
    at->iterations = 1;
    at->evaluations = 0;
    at->most = most;
}

/* Counts the evaluation; whether it was the last one. `step` becomes Newton's. */
static inline int diffuse_contact_is_over(diffuse_contact_equations *at, double *step) {
    const int size = at->size;
    at->evaluations++;
    diffuse_contact_newton_step(at, step);
    at->relative =
        diffuse_contact_larger(diffuse_contact_norm(size, step) * (1e-12 / 1e-6), diffuse_contact_norm(size, at->residual)) /
        diffuse_contact_larger(diffuse_contact_norm(size, at->start) + 1e-290, diffuse_contact_norm(size, at->y));
    /* A NaN is found by any comparison then. */
    if (!(at->relative < INFINITY)) at->relative = INFINITY;
    return at->evaluations >= at->most || at->relative < 1e-12;
}

/* Takes the residuals at y + step and their Jacobian; returns whether this was the last evaluation. */
static inline int diffuse_contact_advance(diffuse_contact_equations *at, const double *residual, const double *jacobian) {
    const int size = at->size, is_first = at->evaluations == 0, is_active = !(at->relative < 1e-12);
    const int is_accepted = is_first || (is_active && diffuse_contact_squared(size, at->unit, residual) <
                                                          diffuse_contact_squared(size, at->unit, at->residual));
    double step[8];
    if (is_accepted) {
        for (int k = 0; k < size; k++) at->y[k] += at->step[k], at->residual[k] = residual[k];
        for (int k = 0; k < size * size; k++) at->jacobian[k] = jacobian[k];
        diffuse_contact_newton_step(at, step);
        const double length = diffuse_contact_norm(size, step), factor = at->longest < length ? at->longest / length : 1.0;
        for (int k = 0; k < size; k++) at->step[k] = factor * step[k];
    } else {
        for (int k = 0; k < size; k++) at->step[k] *= 0.5;
    }
    if (is_first) {
        at->unit = 1.0 / (diffuse_contact_norm(size, residual) + 1e-290);
        for (int k = 0; k < size; k++) at->start[k] = residual[k];
    } else {
        at->iterations += is_active;
    }
    if (!diffuse_contact_is_over(at, step)) return 0;
    /* One that has not converged takes no last step, as from a singular Jacobian. */
    for (int k = 0; k < size && at->relative < 1e-12; k++) at->y[k] += step[k];
    return 1;
}
#endif
