/* What a call from C costs: dc_gap on elements of 8 to 20 masters.
 *
 *     cc -std=c11 -O2 overhead.c $(pkg-config --cflags --libs diffuse_contact) -lm -o overhead && ./overhead
 *
 * Prints the nanoseconds of a call, by the fastest of 200 runs of 200 calls, or of as many as the arguments say. overhead.rs does the same in Rust: the difference is what the way
 * through C costs. Run them by turns on a machine that is otherwise idle.
 */
#define _POSIX_C_SOURCE 199309L
#include <diffuse_contact.h>

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { MOST = 20 };

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

int main(int count_of_arguments, char **arguments) {
    const int runs = count_of_arguments > 1 ? atoi(arguments[1]) : 200, calls = count_of_arguments > 2 ? atoi(arguments[2]) : 200;
    static double masters[3 * MOST], gradient[3 * (MOST + 1)], hessian[3 * (MOST + 1) * (3 * MOST + 4) / 2];
    const double slave[3] = {0.1, 0.2, 0.25};
    for (int k = 0; k < MOST; ++k) {
        masters[3 * k] = k % 5 - 2.0 + 0.03 * (k % 3);
        masters[3 * k + 1] = k / 5 - 1.5 + 0.02 * (k % 4);
        masters[3 * k + 2] = 0.01 * (k % 7);
    }
    dc_element element = {
        .size = sizeof element, .support_radius = 4.0, .frame = DC_GIVEN, .t1 = {1, 0, 0}, .t2 = {0, 1, 0}, .normal = {0, 0, 1}};
    dc_point point;
    printf("ns of a call from C, %s\n   n    gap      N      M\n", dc_isa());
    for (size_t count = 8; count <= MOST; count += 4) {
        printf("%4zu", count);
        for (int mode = DC_VALUE; mode <= DC_HESSIAN; ++mode) {
            double best = 1e300;
            for (int run = 0; run < runs; ++run) {
                double start = now();
                for (int call = 0; call < calls; ++call) {
                    if (dc_gap(&element, slave, masters, count, mode, &point, gradient, sizeof gradient / sizeof *gradient, hessian,
                               sizeof hessian / sizeof *hessian)) {
                        fprintf(stderr, "%s\n", dc_message());
                        return 1;
                    }
                }
                double time = (now() - start) / calls;
                if (time < best) best = time;
            }
            printf(" %6.0f", best);
        }
        printf("\n");
    }
    return 0;
}
