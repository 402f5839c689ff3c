/* The inverse of the rate-dependent Prandtl-Ishlinskii model as a plain C loop: what the Rust step
 * is measured against. A program of its own, so that nothing is linked and both sides are timed in
 * their own process.
 *
 *     gcc -O3 -march=native -ffp-contract=off -DREAL=float -DN=3 rdpi.c -o rdpi
 *     rdpi PARAMETERS INPUT OUTPUT REPETITIONS
 *
 * PARAMETERS holds b_0, beta/h, s_1..s_N, b_1..b_N, INPUT the samples, OUTPUT the results: raw
 * REALs. For each line on standard input the program runs REPETITIONS times over all samples and
 * prints the nanoseconds of the fastest run per sample; at the end of standard input it writes
 * OUTPUT.
 *
 * The operations and their order are those of the Rust core, so that the outputs agree bit for bit;
 * -ffp-contract=off keeps the compiler from fusing them. Conditional expressions become minss and
 * maxss, which fmin and fmax do not.
 */
#define _POSIX_C_SOURCE 199309L
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#ifndef REAL
#define REAL float
#endif
#ifndef N
#define N 3
#endif
typedef REAL real;

typedef struct {
    real weight_0;
    real beta_per_sample;
    real thresholds[N];
    real weights[N];
} parameters;

static inline real lesser(real a, real b) { return a < b ? a : b; }
static inline real greater(real a, real b) { return a > b ? a : b; }
static inline real magnitude(real a) {
    return sizeof(real) == sizeof(float) ? (real)__builtin_fabsf((float)a)
                                         : (real)__builtin_fabs((double)a);
}

__attribute__((noinline)) static void run(const parameters *p, size_t samples,
                                          const real *restrict input, real *restrict output) {
    real r[N], w[N], z[N];
    for (int i = 0; i < N; i++) {
        r[i] = p->thresholds[i];
        w[i] = p->weights[i];
        z[i] = 0;
    }
    const real weight_0 = p->weight_0, beta_per_sample = p->beta_per_sample;
    real previous = input[0];
    for (size_t k = 0; k < samples; k++) {
        const real u = input[k];
        const real half_width = beta_per_sample * magnitude(u - previous);
        const real lo = u - half_width, hi = u + half_width;
        previous = u;
        real sum = weight_0 * u;
#ifdef UNROLL
#pragma GCC unroll 16
#endif
        for (int i = 0; i < N; i++) {
            z[i] = greater(lesser(z[i], hi + r[i]), lo - r[i]);
            sum += w[i] * z[i];
        }
        output[k] = sum;
    }
}

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}

static void fail(const char *what) {
    perror(what);
    exit(1);
}

int main(int argc, char **argv) {
    if (argc != 5) {
        fprintf(stderr, "usage: rdpi PARAMETERS INPUT OUTPUT REPETITIONS\n");
        return 2;
    }
    parameters p;
    FILE *file = fopen(argv[1], "rb");
    if (!file || fread(&p, sizeof p, 1, file) != 1) fail(argv[1]);
    fclose(file);

    file = fopen(argv[2], "rb");
    if (!file || fseek(file, 0, SEEK_END) != 0) fail(argv[2]);
    const size_t samples = (size_t)ftell(file) / sizeof(real);
    rewind(file);
    real *input = malloc(samples * sizeof(real)), *output = calloc(samples, sizeof(real));
    if (!input || !output || fread(input, sizeof(real), samples, file) != samples) fail(argv[2]);
    fclose(file);

    const long repetitions = strtol(argv[4], NULL, 10);
    char line[16];
    while (fgets(line, sizeof line, stdin)) {
        double fastest = 1e300;
        for (long i = 0; i < repetitions; i++) {
            const double start = now();
            run(&p, samples, input, output);
            const double elapsed = now() - start;
            if (elapsed < fastest) fastest = elapsed;
        }
        printf("%.6f\n", fastest / (double)samples);
        fflush(stdout);
    }

    file = fopen(argv[3], "wb");
    if (!file || fwrite(output, sizeof(real), samples, file) != samples || fclose(file) != 0)
        fail(argv[3]);
    return 0;
}
