/* A child evaluates an interface of its parent, and contact over faces, and gets the same numbers in threads of its own. */
#define _POSIX_C_SOURCE 200112L
#include <diffuse_contact.h>

#include <stdio.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

enum { SIDE = 30, MASTERS = SIDE * SIDE, FACETS = (SIDE - 1) * (SIDE - 1) };
enum { OWN = SIDE - 8, SLAVES = OWN * OWN, FACES = (OWN - 1) * (OWN - 1), NODES = MASTERS + SLAVES };

/* At the slaves, then pressures at the integration points. */
struct results {
    double gaps[SLAVES];
    size_t points;
    double pressures[40 * FACES];
};

static double positions[3 * NODES];
static int32_t facets[4 * FACETS], slave_facets[4 * FACES], slaves[SLAVES];
static struct results results[2];

static void check(enum dc_status status) {
    if (status != DC_OK) {
        fprintf(stderr, "%s\n", dc_message());
        exit(1);
    }
}

static void evaluate(dc_interface *interface, dc_faces *faces, struct results *into) {
    dc_pattern *pattern;
    check(dc_refresh(interface, positions, NODES, NULL));
    check(dc_evaluate(interface, DC_HESSIAN));
    check(dc_pattern_create(interface, &pattern, NULL));
    check(dc_pattern_destroy(pattern));
    check(dc_gaps(interface, NULL, into->gaps, SLAVES));
    dc_law law = {.size = sizeof law, .penalty = 1e3};
    size_t room = sizeof into->pressures / sizeof *into->pressures;
    check(dc_faces_refresh(faces, positions, NODES, NULL));
    check(dc_faces_evaluate(faces, &law, DC_GRADIENT));
    check(dc_faces_points(faces, NULL, NULL, NULL, NULL, NULL, into->pressures, NULL, room, &into->points));
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
    for (int k = 0; k < FACES; ++k) {
        int32_t first = MASTERS + k % (OWN - 1) + OWN * (k / (OWN - 1));
        int32_t corners[4] = {first, first + OWN, first + OWN + 1, first + 1};
        for (int j = 0; j < 4; ++j) slave_facets[4 * k + j] = corners[j];
    }
    dc_interface *interface;
    dc_faces *faces;
    check(dc_create(positions, NODES, facets, FACETS, slaves, SLAVES, NULL, 0, NULL, &interface));
    check(dc_faces_create(positions, NODES, facets, FACETS, slave_facets, FACES, NULL, 2, &faces));
    evaluate(interface, faces, &results[0]);
    int ends[2];
    if (pipe(ends)) return 1;
    pid_t child = fork();
    if (child == 0) {
        evaluate(interface, faces, &results[1]);
        size_t put = 0;
        for (ssize_t more; (more = write(ends[1], (char *)&results[1] + put, sizeof results[1] - put)) > 0;) put += (size_t)more;
        _exit(put == sizeof results[1] ? 0 : 1);
    }
    close(ends[1]);
    size_t got = 0;
    for (ssize_t more; (more = read(ends[0], (char *)&results[1] + got, sizeof results[1] - got)) > 0;) got += (size_t)more;
    int status;
    if (waitpid(child, &status, 0) != child || status != 0 || got != sizeof results[1]) return 1;
    for (int k = 0; k < SLAVES; ++k) {
        if (results[0].gaps[k] != results[1].gaps[k] || results[0].gaps[k] >= 0) return 1;
    }
    if (results[0].points < FACES || results[0].points != results[1].points) return 1;
    for (size_t k = 0; k < results[0].points; ++k) {
        if (results[0].pressures[k] != results[1].pressures[k]) return 1;
    }
    /* The parent goes on. */
    evaluate(interface, faces, &results[1]);
    check(dc_faces_destroy(faces));
    check(dc_destroy(interface));
    printf("the child agrees on %d gaps and at all points of %d faces\n", SLAVES, FACES);
    return 0;
}
