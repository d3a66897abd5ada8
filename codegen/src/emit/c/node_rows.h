
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
#endif
