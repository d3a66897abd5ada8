
#ifndef DIFFUSE_CONTACT_NODE_ROWS
#define DIFFUSE_CONTACT_NODE_ROWS
/* Position of the first entry of a row in a packed lower triangle. */
static inline size_t diffuse_contact_packed_row(size_t row) { return row * (row + 1) / 2; }

/* Writes the entries of a packed Hessian that belong to two nodes, d2E/dx_i dx_j = delta_ij D_i + sum b_i^T c_j + c_i^T b_j. Before the
   nodes' rows there are `first` others. `form`: of each node b and c of all products, one after another, then the packed lower triangle of
   D. */
static inline void diffuse_contact_multiply_rows(size_t first, size_t components, size_t products, size_t count, const double *form,
                                                 double *hessian) {
    const size_t own = 2 * products * components, size = own + diffuse_contact_packed_row(components);
    for (size_t i = 0; i < count; i++) {
        for (size_t j = 0; j <= i; j++) {
            const double *x = form + size * i, *y = form + size * j;
            for (size_t a = 0; a < components; a++) {
                double *entries = hessian + diffuse_contact_packed_row(first + components * i + a) + first + components * j;
                for (size_t b = 0; b < (i == j ? a + 1 : components); b++) {
                    double entry = 0.0;
                    for (size_t row = 0; row < 2 * products; row++) entry += x[components * row + a] * y[components * (row ^ 1) + b];
                    entries[b] = i == j ? entry + x[own + diffuse_contact_packed_row(a) + b] : entry;
                }
            }
        }
    }
}

/* Elements that a batch takes side by side: a multiple of the numbers in a vector. */
#ifndef DIFFUSE_CONTACT_LANES
#define DIFFUSE_CONTACT_LANES 8
#endif

/* The same for elements side by side: entry i of an element is at i * DIFFUSE_CONTACT_LANES + lane of `form`, at i * elements + lane of the
   Hessian. Lanes of `form` without an element are set to 0. */
static inline void diffuse_contact_multiply_rows_of_lanes(size_t first, size_t components, size_t products, size_t count, size_t lanes,
                                                          size_t elements, double *DIFFUSE_CONTACT_RESTRICT form, double *DIFFUSE_CONTACT_RESTRICT hessian) {
    const size_t own = 2 * products * components, size = own + diffuse_contact_packed_row(components);
    for (size_t entry = 0; lanes < DIFFUSE_CONTACT_LANES && entry < size * count; entry++)
        for (size_t lane = lanes; lane < DIFFUSE_CONTACT_LANES; lane++) form[entry * DIFFUSE_CONTACT_LANES + lane] = 0.0;
    for (size_t i = 0; i < count; i++) {
        for (size_t j = 0; j <= i; j++) {
            const double *x = form + size * i * DIFFUSE_CONTACT_LANES, *y = form + size * j * DIFFUSE_CONTACT_LANES;
            for (size_t a = 0; a < components; a++) {
                const size_t place = diffuse_contact_packed_row(first + components * i + a) + first + components * j;
                const size_t last = i == j ? a + 1 : components;
                /* Three entries at a time: what is read of x serves all of them. */
                for (size_t b = 0; b < last; b += 3) {
                    const size_t c = b + 1 < components ? b + 1 : b, d = b + 2 < components ? b + 2 : b;
                    double entries[3][DIFFUSE_CONTACT_LANES] = {{0.0}};
                    for (size_t row = 0; row < 2 * products; row++) {
                        const double *of_x = x + (components * row + a) * DIFFUSE_CONTACT_LANES;
                        const double *of_y = y + components * (row ^ 1) * DIFFUSE_CONTACT_LANES;
                        for (size_t lane = 0; lane < DIFFUSE_CONTACT_LANES; lane++) {
                            entries[0][lane] += of_x[lane] * of_y[b * DIFFUSE_CONTACT_LANES + lane];
                            entries[1][lane] += of_x[lane] * of_y[c * DIFFUSE_CONTACT_LANES + lane];
                            entries[2][lane] += of_x[lane] * of_y[d * DIFFUSE_CONTACT_LANES + lane];
                        }
                    }
                    for (size_t e = b; e < last && e < b + 3; e++) {
                        double *entry = entries[e - b];
                        if (i == j) {
                            const double *of_own = x + (own + diffuse_contact_packed_row(a) + e) * DIFFUSE_CONTACT_LANES;
                            for (size_t lane = 0; lane < DIFFUSE_CONTACT_LANES; lane++) entry[lane] += of_own[lane];
                        }
                        for (size_t lane = 0; lane < lanes; lane++) hessian[(place + e) * elements + lane] = entry[lane];
                    }
                }
            }
        }
    }
}
#endif
