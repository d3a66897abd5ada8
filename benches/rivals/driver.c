/* Times and checks a function that CasADi has generated, over many elements, and prints JSON.

   driver INPUTS COUNT SECONDS OUTPUT
   INPUTS   doubles: for each element the function's one argument, a dense column
   COUNT    number of elements
   SECONDS  how long to measure at least
   OUTPUT   file for the results of all elements, doubles, or "-" for none

   FUNCTION, FUNCTION_work, FUNCTION_sparsity_in and FUNCTION_sparsity_out are the generated names. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#define JOIN_(a, b) a##b
#define JOIN(a, b) JOIN_(a, b)
#define WORK JOIN(FUNCTION, _work)
#define SPARSITY_IN JOIN(FUNCTION, _sparsity_in)
#define SPARSITY_OUT JOIN(FUNCTION, _sparsity_out)
#define OUTPUTS JOIN(FUNCTION, _n_out)

typedef long long int integer;
int FUNCTION(const double **arg, double **res, integer *iw, double *w, int mem);
int WORK(integer *arg, integer *res, integer *iw, integer *w);
const integer *SPARSITY_IN(integer i);
const integer *SPARSITY_OUT(integer i);
integer OUTPUTS(void);

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static integer entries(const integer *sparsity) {
    const integer rows = sparsity[0], columns = sparsity[1];
    /* A dense pattern may be abbreviated. */
    return sparsity[2] == 1 ? rows * columns : sparsity[2 + columns];
}

static void *room(size_t count, size_t size) {
    void *memory = calloc(count > 0 ? count : 1, size);
    if (!memory) {
        fprintf(stderr, "error: no memory\n");
        exit(2);
    }
    return memory;
}

int main(int argc, char **argv) {
    if (argc != 5) {
        fprintf(stderr, "usage: driver INPUTS COUNT SECONDS OUTPUT\n");
        return 2;
    }
    const integer count = atoll(argv[2]);
    const double seconds = atof(argv[3]);
    const integer inputs = entries(SPARSITY_IN(0)), outputs = OUTPUTS();
    integer size_arg, size_res, size_iw, size_w, results = 0;
    WORK(&size_arg, &size_res, &size_iw, &size_w);
    for (integer k = 0; k < outputs; ++k) results += entries(SPARSITY_OUT(k));

    double *in = room((size_t)(inputs * count), sizeof *in);
    FILE *file = fopen(argv[1], "rb");
    if (!file || fread(in, sizeof *in, (size_t)(inputs * count), file) != (size_t)(inputs * count)) {
        fprintf(stderr, "error: %s: cannot be read\n", argv[1]);
        return 2;
    }
    fclose(file);

    const double **arg = room((size_t)size_arg, sizeof *arg);
    double **res = room((size_t)size_res, sizeof *res);
    integer *iw = room((size_t)size_iw, sizeof *iw);
    double *w = room((size_t)size_w, sizeof *w);
    double *out = room((size_t)results, sizeof *out);
    double *place = out;
    for (integer k = 0; k < outputs; ++k) {
        res[k] = place;
        place += entries(SPARSITY_OUT(k));
    }

    /* Results of all elements, and the first pass through all caches. */
    file = strcmp(argv[4], "-") ? fopen(argv[4], "wb") : NULL;
    for (integer i = 0; i < count; ++i) {
        arg[0] = in + i * inputs;
        FUNCTION(arg, res, iw, w, 0);
        if (file && fwrite(out, sizeof *out, (size_t)results, file) != (size_t)results) {
            fprintf(stderr, "error: %s: cannot be written\n", argv[4]);
            return 2;
        }
    }
    if (file && fclose(file)) return 2;

    double elapsed = 0.0, sum = 0.0;
    integer calls = 0, next = 0;
    const double start = now();
    do {
        for (int k = 0; k < 16; ++k) {
            arg[0] = in + next * inputs;
            FUNCTION(arg, res, iw, w, 0);
            sum += out[0];
            next = next + 1 == count ? 0 : next + 1;
        }
        calls += 16;
        elapsed = now() - start;
    } while (elapsed < seconds);
    printf("{\"ns_per_element\": %.17g, \"calls\": %lld, \"checksum\": %.17g}\n", 1e9 * elapsed / (double)calls, calls,
           sum);
    return 0;
}
