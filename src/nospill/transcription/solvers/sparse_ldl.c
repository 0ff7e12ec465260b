/* Sparse LDL^T with pivots of one or two rows, behind the entry points of MA27, by which IPOPT loads a linear solver;
   compiled together with pivot_order.c, which comes first.

   All state is in the caller's arrays. IKEEP (3 N): position of each row, width of the pivot at each position (0 at the
   second row of a pair), how far the analysis is. IW: the structure. A: the entries, then the factor. */

/* Added to primal rows, taken off dual ones: a row that depends on others gets the sign that it has in a regular
   matrix. */
static const double REGULARISATION = 1e-12;

enum { NOT_ORDERED, ORDERED, ANALYSED };
enum { LIW_TOO_SMALL = -3, LA_TOO_SMALL = -4, SINGULAR = -5, NO_MEMORY = -20 };

/* ---- structure ---- */

typedef struct {
    int *position, *width;           /* as in IKEEP */
    int *companion;                  /* position of the row that is eliminated with a pivot and no other, -1 for none */
    int *parent;                     /* elimination tree; a pivot goes by the position of its first row */
    int *start, *entry, *other;      /* entries of each row left of the diagonal and on it: index, other position */
    int *first, *end, *row;          /* each column of the factor: where it begins, ends; positions of its rows */
    int *mark, *stack, *path;        /* of a factorisation */
    double *pivot, *coupling;        /* inverted: diagonal, and what stands between the two rows of a pivot */
    double *y;                       /* a pivot's rows in the making, two values a column, zero in between */
    double *factor;                  /* beside `row`; not divided by the pivots */
} View;

enum { HEADER = 1 }; /* of IW: the number of entries */

/* The arrays in IW and A. */
static View view(int n, int entries, int *iw, double *a) {
    View v;
    v.position = iw + HEADER, v.width = v.position + n, v.companion = v.width + n, v.parent = v.companion + n;
    v.end = v.parent + n, v.mark = v.end + n, v.stack = v.mark + n, v.path = v.stack + n, v.start = v.path + n;
    v.first = v.start + n + 1, v.entry = v.first + n + 1, v.other = v.entry + entries;
    v.row = v.other + entries;
    v.pivot = a + entries, v.coupling = v.pivot + n, v.y = v.coupling + n, v.factor = v.y + 2 * n;
    return v;
}

static int head(const View *v, int position) { return v->width[position] ? position : position - 1; }

/* Entries by rows, elimination tree, and the most room that each column of the factor may take. */
static void analyse(const View *v, int n, int entries, const int *row, const int *column) {
    for (int k = 0; k < entries; k++)
        v->other[k] = greater(v->position[row[k] - 1], v->position[column[k] - 1]);
    sort_by(entries, v->other, n, v->start, v->entry);
    for (int q = 0; q < entries; q++)
        v->other[q] = lesser(v->position[row[v->entry[q]] - 1], v->position[column[v->entry[q]] - 1]);
    memset(v->first, 0, ((size_t)n + 1) * sizeof *v->first);
    for (int i = 0; i < n; i++) v->parent[i] = v->mark[i] = v->companion[i] = -1;
    for (int k = 0; k < n && v->width[k] > 0; k += v->width[k]) {
        v->mark[k] = k;
        for (int q = v->start[k]; q < v->start[k + v->width[k]]; q++)
            for (int i = head(v, v->other[q]); v->mark[i] != k; i = v->parent[i]) {
                if (v->parent[i] < 0) v->parent[i] = k;
                v->first[i + 1] += v->width[k];
                v->mark[i] = k;
            }
    }
    for (int i = 0; i < n; i++) {
        if (v->width[i] == 0) v->first[i + 1] = v->first[i] - v->first[i - 1]; /* as much as the row before it */
        if (v->width[i] < 0) v->companion[-1 - v->width[i]] = i;
        v->first[i + 1] += v->first[i];
    }
}

/* ---- numbers ---- */

/* Divide by pivot i what stands in its rows. */
static void divide(const View *v, int i, const double *in, double *out) {
    if (v->width[i] == 1)
        out[0] = in[0] * v->pivot[i];
    else {
        double one = in[0], two = in[1];
        out[0] = one * v->pivot[i] + two * v->coupling[i];
        out[1] = one * v->coupling[i] + two * v->pivot[i + 1];
    }
}

/* Take what column c contributes off one row in the making or two; `one`, `two`: their values there, divided by the
   pivot. */
static void eliminate(const View *v, int c, int rows, double one, double two) {
    const double *restrict f = v->factor;
    double *restrict y = v->y;
    if (rows == 1)
        for (int q = v->first[c]; q < v->end[c]; q++) y[2 * v->row[q]] -= f[q] * one;
    else
        for (int q = v->first[c]; q < v->end[c]; q++) {
            y[2 * v->row[q]] -= f[q] * one;
            y[2 * v->row[q] + 1] -= f[q] * two;
        }
}

/* Invert pivot k. Returns the number of its negative eigenvalues, -1 where it is singular. */
static int invert(const View *v, int k, int second, double d, double c, double e) {
    double determinant = d * e - c * c;
    if (second < 0) {
        v->pivot[k] = 1.0 / d;
        return isfinite(v->pivot[k]) ? d < 0.0 : -1;
    }
    v->pivot[k] = e / determinant, v->pivot[second] = d / determinant, v->coupling[k] = -c / determinant;
    if (!isfinite(v->pivot[k] + v->pivot[second] + v->coupling[k])) return -1;
    return determinant < 0.0 ? 1 : d < 0.0 ? 2 : 0;
}

/* Row of the factor, or two where they are a pair, and the pivot. Returns the number of its negative eigenvalues, -1
   where it is singular. */
static int next_pivot(const View *v, int n, int k, const double *value) {
    int rows = v->width[k], companion = v->companion[k], second = rows == 2 ? k + 1 : companion, top = n;
    double d = v->pivot[k], c = 0.0, e = second < 0 ? 0.0 : v->pivot[second];
    v->mark[k] = k;
    for (int part = 0; part < rows; part++)
        for (int q = v->start[k + part]; q < v->start[k + part + 1]; q++) {
            int j = v->other[q], length = 0;
            if (j >= k) {
                *(part == 0 ? &d : j == k ? &c : &e) += value[v->entry[q]];
                continue;
            }
            v->y[2 * j + part] += value[v->entry[q]];
            for (int i = head(v, j); v->mark[i] != k; i = v->parent[i]) v->path[length++] = i, v->mark[i] = k;
            while (length) v->stack[--top] = v->path[--length];
        }
    if (companion >= 0)
        for (int q = v->start[companion]; q < v->start[companion + 1]; q++)
            *(v->other[q] == companion ? &e : &c) += value[v->entry[q]];
    for (; top < n; top++) {
        int i = v->stack[top], width = v->width[i];
        double *y = v->y + 2 * i, at[2][2] = {{y[0], 0.0}, {y[1], 0.0}}, by[2][2] = {{0.0, 0.0}, {0.0, 0.0}};
        y[0] = y[1] = 0.0;
        if (width == 2) at[0][1] = y[2], at[1][1] = y[3], y[2] = y[3] = 0.0;
        for (int part = 0; part < rows; part++) divide(v, i, at[part], by[part]);
        for (int own = 0; own < width; own++) {
            eliminate(v, i + own, rows, by[0][own], by[1][own]);
            for (int part = 0; part < rows; part++)
                if (at[part][own] != 0.0) /* of the two columns of a pair often one is empty here */
                    v->row[v->end[i + own]] = k + part, v->factor[v->end[i + own]++] = at[part][own];
        }
        d -= at[0][0] * by[0][0] + at[0][1] * by[0][1];
        c -= at[1][0] * by[0][0] + at[1][1] * by[0][1];
        e -= at[1][0] * by[1][0] + at[1][1] * by[1][1];
    }
    return invert(v, k, second, d, c, e);
}

/* Returns the number of negative eigenvalues, -1 where a pivot is singular. */
static int factorise(const View *v, int n, const double *value) {
    int negative = 0;
    memset(v->y, 0, 2 * (size_t)n * sizeof *v->y);
    for (int i = 0; i < n; i++) v->mark[i] = -1, v->end[i] = v->first[i];
    for (int k = 0; k < n && v->width[k] > 0; k += v->width[k]) {
        int count = next_pivot(v, n, k, value);
        if (count < 0) return -1;
        negative += count;
    }
    return negative;
}

/* x <- solution, by position. */
static void substitute(const View *v, int n, double *x) {
    int last = 0;
    for (int i = 0; i < n && v->width[i] > 0; i += v->width[i]) {
        int companion = v->companion[i];
        double one = x[i];
        divide(v, i, x + i, x + i);
        if (companion >= 0) {
            x[i] += x[companion] * v->coupling[i];
            x[companion] = one * v->coupling[i] + x[companion] * v->pivot[companion];
        }
        for (last = i; last < i + v->width[i]; last++)
            for (int q = v->first[last]; q < v->end[last]; q++) x[v->row[q]] -= v->factor[q] * x[last];
    }
    for (int i = last - 1; i >= 0; i--) {
        double sum[2] = {0.0, 0.0};
        if (v->width[i] == 0) continue;
        for (int own = 0; own < v->width[i]; own++)
            for (int q = v->first[i + own]; q < v->end[i + own]; q++) sum[own] += v->factor[q] * x[v->row[q]];
        if (v->companion[i] >= 0) x[v->companion[i]] -= sum[0] * v->coupling[i];
        divide(v, i, sum, sum);
        for (int own = 0; own < v->width[i]; own++) x[i + own] -= sum[own];
    }
}

/* ---- entry points; the arguments of MA27, of which only those named here are looked at ---- */

void ma27id_(int *icntl, double *cntl) { memset(icntl, 0, 30 * sizeof *icntl), memset(cntl, 0, 5 * sizeof *cntl); }

/* The pivots need the values, so there is no more to do here than to guess how much room they need. */
void ma27ad_(const int *n, const int *nz, const int *irn, const int *icn, int *iw, const int *liw, int *ikeep, int *iw1,
             int *nsteps, const int *iflag, const int *icntl, const double *cntl, int *info, double *ops) {
    memset(info, 0, 20 * sizeof *info);
    (void)irn, (void)icn, (void)iw, (void)liw, (void)iw1, (void)iflag, (void)icntl, (void)cntl;
    ikeep[2 * *n] = NOT_ORDERED;
    info[4] = 4 * *nz + 8 * *n;
    info[5] = 4 * *nz + 14 * *n;
    *nsteps = 1;
    *ops = 0.0;
}

void ma27bd_(const int *n, const int *nz, const int *irn, const int *icn, double *a, const int *la, int *iw,
             const int *liw, int *ikeep, const int *nsteps, int *maxfrt, int *iw1, const int *icntl, const double *cntl,
             int *info) {
    int *state = ikeep + 2 * *n, negative;
    long long need_iw = HEADER + 10LL * *n + 2 + 2LL * *nz, need_a;
    View v;
    (void)nsteps, (void)iw1, (void)icntl, (void)cntl;
    memset(info, 0, 20 * sizeof *info);
    *maxfrt = *n;
    if (*state == NOT_ORDERED) {
        if (!order_pivots(*n, *nz, irn, icn, a, ikeep, ikeep + *n)) {
            info[0] = NO_MEMORY;
            return;
        }
        *state = ORDERED;
    }
    if (*state == ORDERED) {
        if (need_iw > *liw) {
            info[0] = LIW_TOO_SMALL, info[1] = (int)need_iw;
            return;
        }
        v = view(*n, *nz, iw, a);
        memcpy(v.position, ikeep, 2 * (size_t)*n * sizeof *ikeep);
        analyse(&v, *n, *nz, irn, icn);
    } else
        v = view(*n, *nz, iw, a);
    need_iw += v.first[*n], need_a = *nz + 4LL * *n + v.first[*n];
    if (need_iw > *liw || need_a > *la) {
        *state = ORDERED; /* the caller does not keep what is in IW */
        info[0] = need_iw > *liw ? LIW_TOO_SMALL : LA_TOO_SMALL;
        info[1] = (int)(need_iw > *liw ? need_iw : need_a);
        return;
    }
    *state = ANALYSED;
    iw[0] = *nz;
    int primal = primal_rows(*nz, irn, icn);
    for (int i = 0; i < *n; i++) v.pivot[v.position[i]] = i < primal ? REGULARISATION : -REGULARISATION;
    negative = factorise(&v, *n, a);
    if (negative < 0)
        info[0] = SINGULAR;
    else
        info[14] = negative;
}

void ma27cd_(const int *n, double *a, const int *la, int *iw, const int *liw, double *w, const int *maxfrt, double *rhs,
             int *iw1, const int *nsteps, const int *icntl, const double *cntl) {
    View v = view(*n, iw[0], iw, a);
    (void)la, (void)liw, (void)maxfrt, (void)iw1, (void)nsteps, (void)icntl, (void)cntl;
    for (int i = 0; i < *n; i++) w[v.position[i]] = rhs[i];
    substitute(&v, *n, w);
    for (int i = 0; i < *n; i++) rhs[i] = w[v.position[i]];
}
