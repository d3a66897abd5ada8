/* A plate on springs is pressed on a parabolic ridge: an interface in a Newton iteration, from C.
 *
 *     cc -std=c11 press.c $(pkg-config --cflags --libs diffuse_contact) -lm -o press && ./press
 *
 * Master: 9 x 9 nodes of a ridge that is held, outside above. Slave: 5 x 5 nodes above it, each on springs whose ends are
 * moved down in four increments. Unknowns are the displacements of the slaves. The iteration converges quadratically; the force
 * in the springs is that of the contact. With --bits it prints every number in hexadecimal, so that nothing is lost.
 */
#include <diffuse_contact.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    SIDE = 9,
    MASTERS = SIDE * SIDE,
    FACETS = (SIDE - 1) * (SIDE - 1),
    ROW = 5,
    SLAVES = ROW * ROW,
    SLAVE_FACETS = (ROW - 1) * (ROW - 1),
    NODES = MASTERS + SLAVES,
    UNKNOWNS = 3 * SLAVES,
    INCREMENTS = 4,
    MOST_ITERATIONS = 12
};

static const double SPRING = 40.0;   /* force per length, each node and axis */
static const double PENALTY = 2.0e3; /* force per length^3: contacts carry areas */
static const double TRAVEL = 0.4;    /* of the springs' ends, in all */

static int print_bits = 0;

/* Ends the program unless the call was done. */
static void check(enum dc_status status, const char *call) {
    if (status != DC_OK) {
        fprintf(stderr, "%s: %s\n", call, dc_message());
        exit(1);
    }
}

/* Prints numbers so that they can be read back bit for bit. */
static void print(const char *name, const double *values, size_t count) {
    if (print_bits) {
        printf("%s", name);
        for (size_t k = 0; k < count; ++k) printf(" %a", values[k]);
        printf("\n");
    }
}

/* Gaussian elimination with pivoting, in place: A x = b, the solution in b. */
static void solve(double a[UNKNOWNS][UNKNOWNS], double b[UNKNOWNS]) {
    for (int column = 0; column < UNKNOWNS; ++column) {
        int pivot = column;
        for (int row = column + 1; row < UNKNOWNS; ++row) {
            if (fabs(a[row][column]) > fabs(a[pivot][column])) pivot = row;
        }
        for (int k = 0; k < UNKNOWNS; ++k) {
            double held = a[column][k];
            a[column][k] = a[pivot][k];
            a[pivot][k] = held;
        }
        double held = b[column];
        b[column] = b[pivot];
        b[pivot] = held;
        for (int row = column + 1; row < UNKNOWNS; ++row) {
            double factor = a[row][column] / a[column][column];
            for (int k = column; k < UNKNOWNS; ++k) a[row][k] -= factor * a[column][k];
            b[row] -= factor * b[column];
        }
    }
    for (int row = UNKNOWNS - 1; row >= 0; --row) {
        for (int k = row + 1; k < UNKNOWNS; ++k) b[row] -= a[row][k] * b[k];
        b[row] /= a[row][row];
    }
}

int main(int argument_count, char **arguments) {
    static double positions[3 * NODES], springs[3 * SLAVES];
    static int32_t facets[4 * FACETS], slave_facets[4 * SLAVE_FACETS], slaves[SLAVES], equations[3 * NODES];
    static double stiffness[UNKNOWNS][UNKNOWNS];
    print_bits = argument_count > 1 && strcmp(arguments[1], "--bits") == 0;

    /* 1. The mesh. */
    for (int k = 0; k < MASTERS; ++k) {
        double x = k % SIDE, y = k / SIDE;
        positions[3 * k] = x;
        positions[3 * k + 1] = y;
        positions[3 * k + 2] = -0.05 * (x - 4.0) * (x - 4.0);
    }
    for (int k = 0; k < FACETS; ++k) {
        int32_t first = k % (SIDE - 1) + SIDE * (k / (SIDE - 1));
        int32_t corners[4] = {first, first + 1, first + SIDE + 1, first + SIDE};
        memcpy(facets + 4 * k, corners, sizeof corners);
    }
    for (int k = 0; k < SLAVES; ++k) {
        double *slave = positions + 3 * (MASTERS + k);
        slave[0] = 2.3 + 0.8 * (k % ROW);
        slave[1] = 2.2 + 0.9 * (k / ROW);
        slave[2] = 0.05;
        memcpy(springs + 3 * k, slave, 3 * sizeof *slave);
        slaves[k] = MASTERS + k;
    }
    for (int k = 0; k < SLAVE_FACETS; ++k) { /* facing down */
        int32_t first = MASTERS + k % (ROW - 1) + ROW * (k / (ROW - 1));
        int32_t corners[4] = {first, first + ROW, first + ROW + 1, first + 1};
        memcpy(slave_facets + 4 * k, corners, sizeof corners);
    }

    /* 2. The interface. Nodes of the ridge have no equations. */
    dc_options options = {.size = sizeof options};
    check(dc_options_default(&options), "dc_options_default");
    options.areas = 1;
    dc_interface *interface;
    check(dc_create(positions, NODES, facets, FACETS, slaves, SLAVES, slave_facets, SLAVE_FACETS, &options, &interface),
          "dc_create");
    for (int k = 0; k < 3 * NODES; ++k) equations[k] = k < 3 * MASTERS ? -1 : k - 3 * MASTERS;
    check(dc_set_equations(interface, equations, NODES, UNKNOWNS), "dc_set_equations");
    dc_law law = {.size = sizeof law, .penalty = PENALTY};

    for (int increment = 1; increment <= INCREMENTS; ++increment) {
        /* 3. Start of an increment: pair, and hold the pairing; the pattern holds as long. */
        for (int k = 0; k < SLAVES; ++k) springs[3 * k + 2] -= TRAVEL / INCREMENTS;
        dc_report report = {.size = sizeof report};
        check(dc_refresh(interface, positions, NODES, &report), "dc_refresh");
        check(dc_freeze(interface), "dc_freeze");
        print("refresh", positions, 3 * NODES);
        printf("increment %d: %d paired, %d kept\n", increment, report.paired, report.kept);
        check(dc_evaluate(interface, DC_VALUE), "dc_evaluate");
        dc_pattern *pattern;
        size_t entries;
        check(dc_pattern_create(interface, &pattern, &entries), "dc_pattern_create");
        int32_t *row_offsets = malloc((UNKNOWNS + 1) * sizeof *row_offsets);
        int32_t *columns = malloc(entries * sizeof *columns);
        double *values = malloc(entries * sizeof *values);
        if (!row_offsets || !columns || !values) return 1;
        check(dc_pattern_structure(pattern, row_offsets, UNKNOWNS + 1, columns, entries), "dc_pattern_structure");

        for (int iteration = 0;; ++iteration) {
            /* 4. An iteration: evaluate at the positions of the moment. */
            check(dc_update(interface, positions, NODES), "dc_update");
            check(dc_evaluate(interface, DC_HESSIAN), "dc_evaluate");
            double cutback;
            check(dc_cutback(interface, &cutback), "dc_cutback");
            if (cutback < 1.0) {
                fprintf(stderr, "the increment is too large: cut back by %g\n", cutback);
                return 1;
            }
            double residual[UNKNOWNS], gaps[SLAVES];
            int32_t outcomes[SLAVES];
            size_t active;
            memset(residual, 0, sizeof residual);
            check(dc_add_forces(interface, &law, residual, UNKNOWNS, &active), "dc_add_forces");
            check(dc_gaps(interface, outcomes, gaps, SLAVES), "dc_gaps");
            print("positions", positions, 3 * NODES);
            print("gaps", gaps, SLAVES);
            print("residual", residual, UNKNOWNS);

            /* 5. The equations: contact and springs. Far from equilibrium the tangent is e N N^T alone. */
            double norm = 0.0, force = 0.0;
            for (int row = 0; row < UNKNOWNS; ++row) {
                double spring = SPRING * (springs[row] - positions[3 * MASTERS + row]);
                force = fmax(force, fmax(fabs(residual[row]), fabs(spring)));
                residual[row] += spring;
                norm = fmax(norm, fabs(residual[row]));
            }
            law.tangent = dc_adaptive_tangent(norm, force);
            check(dc_pattern_fill(pattern, interface, &law, values, entries, NULL), "dc_pattern_fill");
            print(law.tangent == DC_EXACT ? "tangent" : "tangent-far", values, entries);
            memset(stiffness, 0, sizeof stiffness);
            for (int row = 0; row < UNKNOWNS; ++row) {
                for (int32_t k = row_offsets[row]; k < row_offsets[row + 1]; ++k) {
                    stiffness[row][columns[k]] = values[k];
                }
                stiffness[row][row] += SPRING;
            }
            printf("  iteration %d: %2zu active, residual %.1e\n", iteration, active, norm);
            if (norm < 1e-10) break;
            if (iteration == MOST_ITERATIONS) {
                fprintf(stderr, "no convergence\n");
                return 1;
            }
            solve(stiffness, residual);
            for (int row = 0; row < UNKNOWNS; ++row) positions[3 * MASTERS + row] += residual[row];
        }

        /* 6. Accepted: what a post-processor shows. */
        double penetrations[SLAVES], forces[SLAVES], pressures[SLAVES], total = 0.0, deepest = 0.0;
        check(dc_forces(interface, &law, penetrations, forces, pressures, SLAVES), "dc_forces");
        for (int k = 0; k < SLAVES; ++k) {
            total += forces[k];
            deepest = fmax(deepest, penetrations[k]);
        }
        print("pressures", pressures, SLAVES);
        printf("  contact force %.9f, deepest penetration %.9f\n", total, deepest);
        free(values);
        free(columns);
        free(row_offsets);
        check(dc_pattern_destroy(pattern), "dc_pattern_destroy");
        check(dc_thaw(interface), "dc_thaw");
    }

    /* 7. One element without an interface: a flat patch, a slave 0.25 above it. */
    double patch[27], slave[3] = {0.1, 0.2, 0.25}, gradient[30], hessian[465];
    for (int k = 0; k < 9; ++k) {
        patch[3 * k] = k % 3 - 1.0;
        patch[3 * k + 1] = k / 3 - 1.0;
        patch[3 * k + 2] = 0.01 * k * k;
    }
    dc_element element = {.size = sizeof element, .support_radius = 2.0, .outward = {0.0, 0.0, 1.0}};
    dc_point point;
    check(dc_gap(&element, slave, patch, 9, DC_HESSIAN, &point, gradient, 30, hessian, 465), "dc_gap");
    printf("one element: gap %.9f\n", point.gap);
    print("one", &point.gap, 1);
    print("one-gradient", gradient, 30);
    print("one-hessian", hessian, 465);

    check(dc_destroy(interface), "dc_destroy");
    /* A handle that is no more is told from one that is. */
    return dc_evaluate(interface, DC_VALUE) == DC_BAD_HANDLE ? 0 : 1;
}
