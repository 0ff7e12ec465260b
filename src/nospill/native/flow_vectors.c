/* What the flow in cups (polar_flow.c) computes with: vectors of one number of each of four cups, their exponentials,
   and sums over places of the circle. What calls them is compiled twice, with and without fused products. */
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { ROW = 9, BLOCK = 4 }; /* numbers of the motion at an instant; Fourier orders that are summed at once */
typedef double four __attribute__((vector_size(32)));
typedef long long mask __attribute__((vector_size(32)));

/* 2^x and 2^-x for |x| < 1000: even and odd part in what x is beyond the nearest whole number, whose series end where a
   term is 2e-16 of the sum. */
INLINE void powers_of_two(four x, four *rising, four *falling) {
    const double shift = 6755399441055744.0; /* 1.5 2^52: the whole number is in the last bits of the sum */
    four shifted = x + shift, r = x - (shifted - shift), s = r * r;
    four even = s * 2.5678435993488206e-11 + 7.054911620801123e-09, odd = s * 4.4455382718708116e-10 + 1.01780860092397e-07;
    even = (even * s + 1.321548679014431e-06) * s + 0.0001540353039338161;
    even = ((even * s + 0.009618129107628477) * s + 0.24022650695910072) * s + 1.0;
    odd = (odd * s + 1.5252733804059841e-05) * s + 0.0013333558146428443;
    odd = ((odd * s + 0.05550410866482158) * s + 0.6931471805599453) * r;
    mask whole = (mask)shifted << 52, one = (mask)((four){1.0, 1.0, 1.0, 1.0});
    *rising = (even + odd) * (four)(one + whole);
    *falling = (even - odd) * (four)(one - whole);
}

/* Even and odd parts of values at `spokes` places (s + 1/2) of a circle, at the first half of them. */
INLINE void fold(int spokes, const four *values, four *even, four *odd) {
    for (int s = 0, t = spokes - 1; s <= t; s++, t--) {
        even[s] = s < t ? values[s] + values[t] : values[s];
        odd[s] = values[s] - values[t];
    }
}

/* RINGS rings of folded values, summed with BLOCK cosines and as many sines from order `from` on; tables by places. */
#define FOURIER(RINGS)                                                                                                 \
    do {                                                                                                               \
        four c[RINGS][BLOCK], d[RINGS][BLOCK];                                                                         \
        for (int a = 0; a < RINGS; a++)                                                                                \
            for (int b = 0; b < BLOCK; b++) c[a][b] = d[a][b] = (four){0.0};                                           \
        for (int s = 0; s < half; s++)                                                                                 \
            for (int a = 0; a < RINGS; a++)                                                                            \
                for (int b = 0; b < BLOCK; b++) {                                                                      \
                    c[a][b] += even[a * half + s] * cosine[s * orders + from + b];                                     \
                    d[a][b] += odd[a * half + s] * sine[s * orders + from + b];                                        \
                }                                                                                                      \
        for (int a = 0; a < RINGS; a++)                                                                                \
            for (int b = 0; b < BLOCK; b++) {                                                                          \
                cosines[a * orders + from + b] = c[a][b];                                                              \
                sines[a * orders + from + b] = d[a][b];                                                                \
            }                                                                                                          \
    } while (0)

/* Fourier sums of values (rings, spokes): cosines and sines (rings, orders), orders a multiple of BLOCK. */
INLINE void fourier(int rings, int spokes, int orders, const double *cosine, const double *sine, const four *values,
                    four *even, four *odd, four *cosines, four *sines) {
    const int half = (spokes + 1) / 2;
    for (int g = 0; g < rings; g++) fold(spokes, values + g * spokes, even + g * half, odd + g * half);
    for (int g = 0; g < rings; g++, even += half, odd += half, cosines += orders, sines += orders)
        for (int from = 0; from < orders; from += BLOCK) FOURIER(1);
}

/* Triangular factors in place of a matrix (n, n) by rows, without a choice of pivots; reciprocals of the diagonal. */
INLINE void factorise(int n, four *matrix, four *inverse) {
    for (int k = 0; k < n; k++) {
        const four *restrict pivot = matrix + k * n;
        inverse[k] = 1.0 / pivot[k];
        for (int i = k + 1; i < n; i++) {
            four *restrict row = matrix + i * n, factor = row[k] *= inverse[k];
            for (int j = k + 1; j < n; j++) row[j] -= factor * pivot[j];
        }
    }
}

/* Solution of matrix x = x by its factors, in place. */
INLINE void solve(int n, const four *matrix, const four *inverse, four *x) {
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) x[i] -= matrix[i * n + j] * x[j];
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++) x[i] -= matrix[i * n + j] * x[j];
        x[i] *= inverse[i];
    }
}

/* The same with the transposed matrix. */
INLINE void solve_transposed(int n, const four *matrix, const four *inverse, four *x) {
    for (int i = 0; i < n; i++) {
        x[i] *= inverse[i];
        for (int j = i + 1; j < n; j++) x[j] -= matrix[i * n + j] * x[i];
    }
    for (int i = n - 1; i > 0; i--)
        for (int j = 0; j < i; j++) x[j] -= matrix[i * n + j] * x[i];
}
