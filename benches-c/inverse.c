/* Inverse of the rate-dependent Prandtl-Ishlinskii model in plain C, for the benchmark alone.
 *
 * The same work as the Rust step: rate from two samples, envelopes, bank of plays, weighted sum.
 * Conditional expressions rather than fmaxf, sizes known to the compiler, state and parameters side by
 * side: the fastest plain form we found with gcc -O3.
 */
#define INVERSE(N)                                                                  \
    struct inverse_##N {                                                            \
        float weight_0, beta_per_sample, previous;                                  \
        float thresholds[N], weights[N], z[N];                                      \
    };                                                                              \
    float inverse_##N(struct inverse_##N *s, float v);                              \
    float inverse_##N(struct inverse_##N *s, float v)                               \
    {                                                                               \
        const float half = s->beta_per_sample * __builtin_fabsf(v - s->previous);   \
        const float lo = v - half, hi = v + half;                                   \
        float sum = s->weight_0 * v;                                                \
        s->previous = v;                                                            \
        for (int i = 0; i < N; i++) {                                               \
            const float up = hi + s->thresholds[i], down = lo - s->thresholds[i];   \
            float z = s->z[i];                                                      \
            z = z < up ? z : up;                                                    \
            z = z > down ? z : down;                                                \
            s->z[i] = z;                                                            \
            sum += s->weights[i] * z;                                               \
        }                                                                           \
        return sum;                                                                 \
    }

INVERSE(3)
INVERSE(10)
INVERSE(100)
