/* The dense part of a factorisation: products of columns. What calls them is compiled twice, with and without the fused
   products of vectors that most processors have. */

#if !defined(WITHOUT_FMA) && defined(__x86_64__) && defined(__GNUC__)
#define WITH_FMA __attribute__((target("avx2,fma")))
#define HAS_FMA (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
#else
#define WITH_FMA
#define HAS_FMA 0
#endif

#define INLINE static inline __attribute__((always_inline))

typedef double Two __attribute__((vector_size(16), aligned(8), may_alias));
typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));

/* Rows of c from i on, COUNT vectors of them, and four of its columns from j on. */
#define BLOCK(VECTOR, COUNT)                                                                                           \
    do {                                                                                                               \
        enum { WIDE = sizeof(VECTOR) / sizeof(double) };                                                               \
        VECTOR sum[COUNT][4] = {{{0.0}}};                                                                              \
        for (int l = 0; l < depth; l++) {                                                                              \
            const double *by = f + j + (size_t)l * ld, *of = g + i + (size_t)l * ld;                                   \
            for (int a = 0; a < COUNT; a++) {                                                                          \
                VECTOR rows_of = *(const VECTOR *)(of + WIDE * a);                                                     \
                for (int b = 0; b < 4; b++) sum[a][b] += rows_of * by[b];                                              \
            }                                                                                                          \
        }                                                                                                              \
        for (int a = 0; a < COUNT; a++)                                                                                \
            for (int b = 0; b < 4; b++) *(VECTOR *)(c + i + WIDE * a + (size_t)(j + b) * ldc) -= sum[a][b];            \
        i += WIDE * COUNT;                                                                                             \
    } while (0)

/* c -= g f^T on and below the diagonal: c (rows x columns), g (rows x depth), f the same rows as g, of which the first
   `columns` count; all by columns, ld and ldc apart. Above the diagonal c is left undefined. */
INLINE void update(int rows, int columns, int depth, const double *g, const double *f, int ld, double *c, int ldc,
                   int with_fma) {
    int j = 0;
    for (; j + 4 <= columns; j += 4) {
        int i = j;
        if (with_fma) {
            while (i + 8 <= rows) BLOCK(Four, 2);
            if (i + 4 <= rows) BLOCK(Four, 1);
        } else
            while (i + 4 <= rows) BLOCK(Two, 2);
        for (; i < rows; i++)
            for (int b = j; b < j + 4; b++) {
                double sum = 0.0;
                for (int l = 0; l < depth; l++) sum += g[i + (size_t)l * ld] * f[b + (size_t)l * ld];
                c[i + (size_t)b * ldc] -= sum;
            }
    }
    for (; j < columns; j++)
        for (int l = 0; l < depth; l++) {
            const double *restrict of = g + (size_t)l * ld;
            double by = f[j + (size_t)l * ld];
            double *restrict to = c + (size_t)j * ldc;
            for (int i = j; i < rows; i++) to[i] -= of[i] * by;
        }
}

/* y -= column a, from row `begin` on. */
INLINE void take_off(int rows, int begin, const double *restrict column, double a, double *restrict y) {
    for (int i = begin; i < rows; i++) y[i] -= column[i] * a;
}

INLINE void take_two_off(int rows, int begin, const double *restrict one, const double *restrict two, double a,
                         double b, double *restrict y) {
    for (int i = begin; i < rows; i++) y[i] -= one[i] * a + two[i] * b;
}

/* Sum of the products from row `begin` on, in eight parts. */
INLINE double dot(int rows, int begin, const double *column, const double *y) {
    Four sum[2] = {{0.0}, {0.0}};
    double rest = 0.0;
    int i = begin;
    for (; i + 8 <= rows; i += 8)
        for (int a = 0; a < 2; a++) sum[a] += *(const Four *)(column + i + 4 * a) * *(const Four *)(y + i + 4 * a);
    for (; i < rows; i++) rest += column[i] * y[i];
    sum[0] += sum[1];
    return rest + sum[0][0] + sum[0][1] + sum[0][2] + sum[0][3];
}
