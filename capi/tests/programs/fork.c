/* A child evaluates an interface of its parent, and gets the same numbers in threads of its own. */
#define _POSIX_C_SOURCE 200112L
#include <diffuse_contact.h>

#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

enum { SIDE = 30, MASTERS = SIDE * SIDE, SLAVES = (SIDE - 8) * (SIDE - 8), NODES = MASTERS + SLAVES, FACETS = (SIDE - 1) * (SIDE - 1) };

static double positions[3 * NODES], gaps[2][SLAVES];
static int32_t facets[4 * FACETS], slaves[SLAVES];

static void check(enum dc_status status) {
    if (status != DC_OK) {
        fprintf(stderr, "%s\n", dc_message());
        exit(1);
    }
}

static void evaluate(dc_interface *interface, double *into) {
    dc_pattern *pattern;
    check(dc_refresh(interface, positions, NODES, NULL));
    check(dc_evaluate(interface, DC_HESSIAN));
    check(dc_pattern_create(interface, &pattern, NULL));
    check(dc_pattern_destroy(pattern));
    check(dc_gaps(interface, NULL, into, SLAVES));
}

int main(void) {
    for (int k = 0; k < MASTERS; ++k) {
        positions[3 * k] = k % SIDE;
        positions[3 * k + 1] = k / SIDE;
        positions[3 * k + 2] = 0.01 * (k % 7);
    }
    for (int k = 0; k < FACETS; ++k) {
        int32_t first = k % (SIDE - 1) + SIDE * (k / (SIDE - 1));
        int32_t corners[4] = {first, first + 1, first + SIDE + 1, first + SIDE};
        for (int j = 0; j < 4; ++j) facets[4 * k + j] = corners[j];
    }
    for (int k = 0; k < SLAVES; ++k) {
        double *slave = positions + 3 * (MASTERS + k);
        slave[0] = 4.3 + k % (SIDE - 8);
        slave[1] = 4.4 + k / (SIDE - 8);
        slave[2] = -0.05;
        slaves[k] = MASTERS + k;
    }
    dc_interface *interface;
    check(dc_create(positions, NODES, facets, FACETS, slaves, SLAVES, NULL, 0, NULL, &interface));
    evaluate(interface, gaps[0]);
    int ends[2];
    if (pipe(ends)) return 1;
    pid_t child = fork();
    if (child == 0) {
        evaluate(interface, gaps[1]);
        ssize_t done = write(ends[1], gaps[1], sizeof gaps[1]);
        _exit(done == (ssize_t)sizeof gaps[1] ? 0 : 1);
    }
    close(ends[1]);
    size_t got = 0;
    for (ssize_t more; (more = read(ends[0], (char *)gaps[1] + got, sizeof gaps[1] - got)) > 0;) got += (size_t)more;
    int status;
    if (waitpid(child, &status, 0) != child || status != 0 || got != sizeof gaps[1]) return 1;
    for (int k = 0; k < SLAVES; ++k) {
        if (gaps[0][k] != gaps[1][k] || gaps[0][k] >= 0) return 1;
    }
    /* The parent goes on. */
    evaluate(interface, gaps[1]);
    check(dc_destroy(interface));
    printf("the child agrees on %d gaps\n", SLAVES);
    return 0;
}
