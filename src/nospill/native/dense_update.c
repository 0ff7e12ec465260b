/* The dense part of a factorisation: products of columns. What calls them is compiled twice, with and without the fused
   products of vectors that most processors have. */

typedef double One __attribute__((vector_size(8), aligned(8), may_alias));
typedef double Two __attribute__((vector_size(16), aligned(8), may_alias));
typedef double Four __attribute__((vector_size(32), aligned(8), may_alias));

/* Columns of a panel as the depth of a product: the first ones of pairs, the second ones, single ones. Where each begins
   in the panel, and how many there are. */
typedef struct {
    const int *at[3];
    int count[3];
} Depth;

/* What stands in a row of the first and of the second columns of pairs. */
enum { IN_FIRST = 1, IN_SECOND = 2 };

/* Add the products of some columns to the sums of a block. */
#define SUM_UP(VECTOR, COUNT, COLUMNS, PART)                                                                           \
    for (int l = 0; l < depth->count[PART]; l++) {                                                                     \
        const double *by = f + j + depth->at[PART][l], *of = g + i + depth->at[PART][l];                               \
        for (int a = 0; a < COUNT; a++) {                                                                              \
            VECTOR rows_of = *(const VECTOR *)(of + WIDE * a);                                                         \
            for (int b = 0; b < COLUMNS; b++) sum[a][b] += rows_of * by[b];                                            \
        }                                                                                                              \
    }

/* Rows of c from i on, COUNT vectors of them, and COLUMNS of its columns from j on. */
#define BLOCK(VECTOR, COUNT, COLUMNS)                                                                                  \
    do {                                                                                                               \
        enum { WIDE = sizeof(VECTOR) / sizeof(double), ROWS = WIDE * COUNT };                                          \
        unsigned in_rows = 0;                                                                                          \
        for (int a = 0; a < ROWS; a++) in_rows |= held[i + a];                                                         \
        int first = (in_rows & IN_SECOND) && (in_columns & IN_FIRST), second = (in_columns & IN_SECOND) != 0;          \
        if (!first && !second && !depth->count[2]) {                                                                   \
            i += ROWS;                                                                                                 \
            break;                                                                                                     \
        }                                                                                                              \
        VECTOR sum[COUNT][COLUMNS];                                                                                    \
        for (int a = 0; a < COUNT; a++)                                                                                \
            for (int b = 0; b < COLUMNS; b++) sum[a][b] = (VECTOR){0.0};                                               \
        if (first) SUM_UP(VECTOR, COUNT, COLUMNS, 0)                                                                   \
        if (second) SUM_UP(VECTOR, COUNT, COLUMNS, 1)                                                                  \
        SUM_UP(VECTOR, COUNT, COLUMNS, 2)                                                                              \
        if (!place || place[i + ROWS - 1] - place[i] == ROWS - 1) {                                                    \
            double *from = c + (place ? place[i] : i);                                                                 \
            for (int a = 0; a < COUNT; a++)                                                                            \
                for (int b = 0; b < COLUMNS; b++)                                                                      \
                    *(VECTOR *)(from + WIDE * a + (size_t)(place ? place[j + b] : j + b) * ldc) -= sum[a][b];          \
        } else                                                                                                         \
            for (int b = 0; b < COLUMNS; b++) {                                                                        \
                double *to = c + (size_t)place[j + b] * ldc;                                                           \
                for (int a = 0; a < COUNT; a++)                                                                        \
                    for (int k = 0; k < WIDE; k++) to[place[i + WIDE * a + k]] -= sum[a][b][k];                        \
            }                                                                                                          \
        i += ROWS;                                                                                                     \
    } while (0)

/* All rows from the diagonal on, and COLUMNS columns from j on. */
#define STRIP(COLUMNS)                                                                                                 \
    do {                                                                                                               \
        int i = j;                                                                                                     \
        unsigned in_columns = 0;                                                                                       \
        for (int b = 0; b < COLUMNS; b++) in_columns |= held[j + b];                                                   \
        if (with_fma) {                                                                                                \
            while (i + 8 <= rows) BLOCK(Four, 2, COLUMNS);                                                             \
            if (i + 4 <= rows) BLOCK(Four, 1, COLUMNS);                                                                \
        } else                                                                                                         \
            while (i + 4 <= rows) BLOCK(Two, 2, COLUMNS);                                                              \
        if (i + 2 <= rows) BLOCK(Two, 1, COLUMNS);                                                                     \
        if (i < rows) BLOCK(One, 1, COLUMNS);                                                                          \
        j += COLUMNS;                                                                                                  \
    } while (0)

/* c -= g f^T on and below the diagonal: c (rows x columns), g (rows x depth), f the same rows as g, of which the first
   `columns` count; all by columns. Of a pair the first column of f is zero in rows not held IN_FIRST, the second one and
   the first of g in those not held IN_SECOND. `place`: rows and columns of c by those of the product, ascending; NULL
   where they are the same. Above the diagonal c is left undefined. */
INLINE void subtract_product(int rows, int columns, const Depth *depth, const double *g, const double *f,
                             const unsigned char *held, double *c, int ldc, const int *place, int with_fma) {
    int j = 0;
    while (j + 4 <= columns) STRIP(4);
    if (j + 2 <= columns) STRIP(2);
    if (j < columns) STRIP(1);
}

typedef void Update(int, int, const Depth *, const double *, const double *, const unsigned char *, double *, int,
                    const int *);

WITH_FMA static void update_with_fma(int rows, int columns, const Depth *depth, const double *g, const double *f,
                                     const unsigned char *held, double *c, int ldc, const int *place) {
    subtract_product(rows, columns, depth, g, f, held, c, ldc, place, 1);
}

static void update_without_fma(int rows, int columns, const Depth *depth, const double *g, const double *f,
                               const unsigned char *held, double *c, int ldc, const int *place) {
    subtract_product(rows, columns, depth, g, f, held, c, ldc, place, 0);
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
