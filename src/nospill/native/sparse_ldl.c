/* Sparse LDL^T with pivots of one or two rows, behind the entry points of MA27, by which IPOPT loads a linear solver;
   compiled together with the other files beside it, which come first (`linear_solvers.py`).

   All state is in the caller's arrays. IKEEP (3 N): position of each row, width of the pivot at each position (0 at the
   second row of a pair), how far the analysis is. IW: the structure. A: the entries, then the factor. */

/* Added to primal rows, taken off dual ones without a partner: a row that depends on others gets the sign that it has in
   a regular matrix. The dual row of a pair has minus nothing: while its diagonal is zero, rows that only the other row
   of the pair touches are left alone by its elimination, and products with them are left out. */
static const double REGULARISATION = 1e-12;

/* Least pivot, of a pair its eigenvalue; a smaller one is moved by so much, up in primal rows and down in dual ones. */
static const double LEAST_PIVOT = 1e-9;

enum { NOT_ORDERED, ORDERED, ANALYSED };
enum { LIW_TOO_SMALL = -3, LA_TOO_SMALL = -4, SINGULAR = -5, NO_MEMORY = -20 };

/* ---- numbers ---- */

typedef struct {
    Structure s;
    double *pivot, *coupling; /* inverted: diagonal, and what stands between the two rows of a pivot */
    double *factor;           /* panels, not divided by the pivots; then of each slack its coupling and its diagonal */
    double *work;
    double *sums;        /* of each row of a panel, of the sizes of what stands in second columns */
    unsigned char *held; /* what stands in each row */
    int *depth;          /* where its columns begin, by what they are */
} View;

/* The arrays in IW and A. */
static View view(int n, int *iw, double *a) {
    View v = {.s = structure_in(n, iw)};
    v.pivot = a + v.s.entries, v.coupling = v.pivot + n, v.factor = v.coupling + n;
    v.work = v.factor + v.s.factor + n;
    v.sums = v.work + v.s.most + n;
    v.depth = (int *)(v.sums + n);
    v.held = (unsigned char *)(v.depth + 3 * (size_t)n);
    return v;
}

static long long room(int n, const Structure *s) { return s->entries + 8LL * n + s->factor + s->most + 1; }

/* Divide by pivot i what stands in its rows. */
INLINE void divide(const View *v, int i, const double *in, double *out) {
    if (v->s.width[i] == 1)
        out[0] = in[0] * v->pivot[i];
    else {
        double one = in[0], two = in[1];
        out[0] = one * v->pivot[i] + two * v->coupling[i];
        out[1] = one * v->coupling[i] + two * v->pivot[i + 1];
    }
}

/* Invert pivot k, of the diagonal d and e with c between. Returns the number of its negative eigenvalues, -1 where it
   is singular. Of a pair nothing may be left, though the matrix is regular: dividing by it would lose all digits. It is
   moved by an amount that IPOPT's iterative refinement makes good. */
INLINE int invert(const View *v, int k, int second, double d, double c, double e) {
    if (second < 0) {
        if (fabs(d) < LEAST_PIVOT) d += signbit(v->pivot[k]) ? -LEAST_PIVOT : LEAST_PIVOT;
        v->pivot[k] = 1.0 / d;
        return isfinite(v->pivot[k]) ? d < 0.0 : -1;
    }
    if (fabs(d * e - c * c) < LEAST_PIVOT * fmax(fmax(fabs(d), fabs(e)), fabs(c))) {
        d += signbit(v->pivot[k]) ? -LEAST_PIVOT : LEAST_PIVOT;
        e += signbit(v->pivot[second]) ? -LEAST_PIVOT : LEAST_PIVOT;
    }
    double determinant = d * e - c * c;
    v->pivot[k] = e / determinant, v->pivot[second] = d / determinant, v->coupling[k] = -c / determinant;
    if (!isfinite(v->pivot[k] + v->pivot[second] + v->coupling[k])) return -1;
    return determinant < 0.0 ? 1 : d < 0.0 ? 2 : 0;
}

/* Columns of a panel from `begin` to `end`, up to date but for each other; `divided`: the same by the pivots. Returns
   the number of negative eigenvalues, -1 where a pivot is singular. */
INLINE int eliminate(const View *v, int first, int begin, int end, int own, int height, double *panel,
                     double *divided) {
    int negative = 0;
    for (int k = begin, wide; k < end; k += wide) {
        int at = first + k, companion = v->s.companion[at];
        double *restrict one = panel + (size_t)k * height, *restrict two = one + height;
        double *restrict by_one = divided + (size_t)k * height, *restrict by_two = by_one + height;
        wide = v->s.width[at];
        double d = one[k] + v->pivot[at], c = 0.0, e = 0.0;
        if (wide == 2) c = one[k + 1], e = two[k + 1] + v->pivot[at + 1];
        const double *of_slacks = v->factor + v->s.factor;
        if (companion >= 0) c = of_slacks[at], e = of_slacks[companion] + v->pivot[companion];
        int count = invert(v, at, wide == 2 ? at + 1 : companion, d, c, e);
        if (count < 0) return -1;
        negative += count;
        double p = v->pivot[at];
        if (wide == 1)
            for (int i = k + 1; i < height; i++) by_one[i] = one[i] * p;
        else {
            double q = v->coupling[at], r = v->pivot[at + 1];
            for (int i = k + 2; i < height; i++) {
                by_one[i] = one[i] * p + two[i] * q;
                by_two[i] = one[i] * q + two[i] * r;
                v->sums[i] += fabs(two[i]);
            }
            if (p != 0.0) /* then the first one, divided, holds what either holds */
                for (int i = k + 2; i < height; i++) v->sums[i] += 1.0;
            for (int i = k + 2; i < own; i++) v->held[i] |= one[i] != 0.0 ? IN_FIRST : 0;
        }
        for (int j = k + wide; j < end; j++) {
            double *restrict to = panel + (size_t)j * height, f = one[j], g = wide == 2 ? two[j] : 0.0;
            if (f == 0.0 && g == 0.0) continue; /* always so between leaves */
            if (g == 0.0)
                for (int i = j; i < height; i++) to[i] -= by_one[i] * f;
            else
                for (int i = j; i < height; i++) to[i] -= by_one[i] * f + by_two[i] * g;
        }
    }
    return negative;
}

/* Take what a panel contributes off the panels that its rows are columns of. */
INLINE void contribute(const View *v, int p, int own, int height, const Depth *depth, const double *panel,
                       const double *divided, Update *update) {
    const Structure *s = &v->s;
    int below = height - own;
    for (int u = s->update[p]; u < s->update[p + 1]; u++) {
        int t = s->target[2 * u], from = s->target[2 * u + 1], rows = below - from;
        int until = u + 1 < s->update[p + 1] ? s->target[2 * u + 3] : below, columns = until - from;
        int far = s->first[t + 1] - s->first[t] + s->list[t + 1] - s->list[t];
        const int *local = s->local + s->where[u];
        double *to = v->factor + s->panel[t];
        const double *f = panel + own + from, *g = divided + own + from;
        update(rows, columns, depth, g, f, v->held + own + from, to, far, local);
    }
}

/* Nothing is known of the own rows of a panel that is begun; those below it may have anything in first columns. */
INLINE void forget_rows(const View *v, int own, int height) {
    memset(v->sums, 0, (size_t)height * sizeof *v->sums);
    memset(v->held, 0, (size_t)own);
    memset(v->held + own, IN_FIRST, (size_t)(height - own));
}

/* Note columns of a panel that are eliminated as depth of the products to come, and which rows their second ones hold. */
INLINE void note_columns(const View *v, int n, int first, int begin, int end, int height, Depth *depth) {
    int *singles = v->depth + 2 * (size_t)n, *seconds = v->depth + n, *firsts = v->depth;
    for (int k = begin; k < end; k += v->s.width[first + k])
        if (v->s.width[first + k] == 1)
            singles[depth->count[2]++] = k * height;
        else
            firsts[depth->count[0]++] = k * height, seconds[depth->count[1]++] = (k + 1) * height;
    for (int i = end; i < height; i++) v->held[i] |= v->sums[i] != 0.0 ? IN_SECOND : 0;
}

/* Returns the number of negative eigenvalues, -1 where a pivot is singular. */
INLINE int factorise(const View *v, int n, const double *value, Update *update) {
    const Structure *s = &v->s;
    int negative = 0;
    memset(v->factor, 0, ((size_t)s->factor + n) * sizeof *v->factor);
    for (int k = 0; k < s->entries; k++) v->factor[s->place[k]] += value[k];
    for (int p = 0; p < s->panels; p++) {
        int first = s->first[p], own = s->first[p + 1] - first, height = own + s->list[p + 1] - s->list[p];
        double *panel = v->factor + s->panel[p], *divided = v->work;
        Depth depth = {{v->depth, v->depth + n, v->depth + 2 * (size_t)n}, {0, 0, 0}};
        forget_rows(v, own, height);
        for (int begin = 0, end; begin < own; begin = end) {
            for (end = begin; end < own && end < begin + BLOCK_COLUMNS;) end += s->width[first + end];
            if (begin)
                update(height - begin, end - begin, &depth, divided + begin, panel + begin, v->held + begin,
                       panel + begin + (size_t)begin * height, height, NULL);
            int count = eliminate(v, first, begin, end, own, height, panel, divided);
            if (count < 0) return -1;
            negative += count;
            note_columns(v, n, first, begin, end, height, &depth);
        }
        contribute(v, p, own, height, &depth, panel, divided, update);
    }
    return negative;
}

/* x <- solution, by position; `y`: room for the rows of a panel. */
INLINE void substitute(const View *v, double *x, double *y) {
    const Structure *s = &v->s;
    for (int p = 0; p < s->panels; p++) {
        int first = s->first[p], own = s->first[p + 1] - first, height = own + s->list[p + 1] - s->list[p], wide;
        const int *row = s->row + s->list[p] - own;
        memcpy(y, x + first, (size_t)own * sizeof *y);
        for (int i = own; i < height; i++) y[i] = x[row[i]];
        for (int k = 0; k < own; k += wide) {
            int at = first + k, companion = s->companion[at];
            const double *one = v->factor + s->panel[p] + (size_t)k * height;
            double was = y[k];
            wide = s->width[at];
            divide(v, at, y + k, y + k);
            if (companion >= 0) {
                y[k] += x[companion] * v->coupling[at];
                x[companion] = was * v->coupling[at] + x[companion] * v->pivot[companion];
            }
            if (wide == 1)
                take_off(height, k + 1, one, y[k], y);
            else
                take_two_off(height, k + 2, one, one + height, y[k], y[k + 1], y);
        }
        memcpy(x + first, y, (size_t)own * sizeof *y);
        for (int i = own; i < height; i++) x[row[i]] = y[i];
    }
    for (int p = s->panels - 1; p >= 0; p--) {
        int first = s->first[p], own = s->first[p + 1] - first, height = own + s->list[p + 1] - s->list[p];
        const int *row = s->row + s->list[p] - own;
        memcpy(y, x + first, (size_t)own * sizeof *y);
        for (int i = own; i < height; i++) y[i] = x[row[i]];
        for (int k = own - 1; k >= 0; k--) {
            int at = first + k, wide = s->width[at];
            const double *one = v->factor + s->panel[p] + (size_t)k * height;
            if (wide == 0) continue;
            double sum[2] = {dot(height, k + wide, one, y), 0.0};
            if (wide == 2) sum[1] = dot(height, k + wide, one + height, y);
            if (s->companion[at] >= 0) x[s->companion[at]] -= sum[0] * v->coupling[at];
            divide(v, at, sum, sum);
            for (int part = 0; part < wide; part++) y[k + part] -= sum[part];
        }
        memcpy(x + first, y, (size_t)own * sizeof *y);
    }
}

WITH_FMA static int factorise_with_fma(const View *v, int n, const double *value) { return factorise(v, n, value, update_with_fma); }

WITH_FMA static void substitute_with_fma(const View *v, double *x, double *y) { substitute(v, x, y); }

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
    (void)nsteps, (void)iw1, (void)icntl, (void)cntl;
    memset(info, 0, 20 * sizeof *info);
    *maxfrt = 2 * *n;
    if (*state != ANALYSED) {
        long long length = 0;
        int *given = *state == NOT_ORDERED ? given_structure(*n, *nz, irn, icn, a, &length) : NULL;
        if (given) {
            Structure of = structure_in(*n, given);
            memcpy(ikeep, of.position, (size_t)*n * sizeof *ikeep);
            memcpy(ikeep + *n, of.width, (size_t)*n * sizeof *ikeep);
        } else if (*state == NOT_ORDERED && !order_pivots(*n, *nz, irn, icn, a, ikeep, ikeep + *n)) {
            info[0] = NO_MEMORY;
            return;
        }
        *state = ORDERED;
        int *structure = given ? given : structure_of(*n, *nz, irn, icn, ikeep, ikeep + *n, &length);
        if (!structure || length > INT_MAX) {
            info[0] = NO_MEMORY;
        } else if (length > *liw) {
            info[0] = LIW_TOO_SMALL, info[1] = (int)length;
        } else {
            memcpy(iw, structure, (size_t)length * sizeof *iw);
            note(*n, *nz, irn, icn, structure, length, given != NULL);
        }
        if (!given) free(structure);
        if (info[0]) return;
    }
    View v = view(*n, iw, a);
    if (room(*n, &v.s) > *la) {
        *state = ORDERED; /* the caller does not keep what is in IW */
        info[0] = LA_TOO_SMALL, info[1] = (int)room(*n, &v.s);
        return;
    }
    *state = ANALYSED;
    for (int i = 0; i < *n; i++) {
        int at = v.s.position[i];
        v.pivot[at] = i < v.s.primal ? REGULARISATION : v.s.width[at] ? -REGULARISATION : -0.0;
    }
    negative = HAS_FMA ? factorise_with_fma(&v, *n, a) : factorise(&v, *n, a, update_without_fma);
    if (negative < 0)
        info[0] = SINGULAR;
    else
        info[14] = negative;
}

void ma27cd_(const int *n, double *a, const int *la, int *iw, const int *liw, double *w, const int *maxfrt, double *rhs,
             int *iw1, const int *nsteps, const int *icntl, const double *cntl) {
    View v = view(*n, iw, a);
    (void)la, (void)liw, (void)maxfrt, (void)iw1, (void)nsteps, (void)icntl, (void)cntl;
    for (int i = 0; i < *n; i++) w[v.s.position[i]] = rhs[i];
    if (HAS_FMA)
        substitute_with_fma(&v, w, w + *n);
    else
        substitute(&v, w, w + *n);
    for (int i = 0; i < *n; i++) rhs[i] = w[v.s.position[i]];
}
