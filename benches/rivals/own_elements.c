/* Times and checks a rival's tetrahedron, and prints JSON: driver INPUTS COUNT SECONDS OUTPUT

   INPUTS   26 doubles an element; with BATCH all first ones, then all second ones, …
   SECONDS  how long to measure at least
   OUTPUT   file for the results, 91 doubles an element, in the same order */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

void rival(const double *in, double *out);
void rival_batch(size_t count, const double *restrict in, double *restrict out);

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int argc, char **argv) {
    if (argc != 5) return 2;
    const size_t count = (size_t)atoll(argv[2]);
    const double seconds = atof(argv[3]);
    double *in = calloc(26 * count, sizeof *in), *out = calloc(91 * count, sizeof *out);
    FILE *file = fopen(argv[1], "rb");
    if (!in || !out || !file || fread(in, sizeof *in, 26 * count, file) != 26 * count) return 2;
    fclose(file);
    /* The quickest of many rounds. */
    double best = 1e300;
    const double start = now();
    while (now() - start < seconds) {
        const double round = now();
#ifdef BATCH
        rival_batch(count, in, out);
#else
        for (size_t k = 0; k < count; ++k) rival(in + 26 * k, out + 91 * k);
#endif
        const double elapsed = now() - round;
        best = elapsed < best ? elapsed : best;
    }
    file = fopen(argv[4], "wb");
    if (!file || fwrite(out, sizeof *out, 91 * count, file) != 91 * count || fclose(file)) return 2;
    printf("{\"ns\": %.17g}\n", 1e9 * best / (double)count);
    return 0;
}
