/* Pivots that outlive a solve: one that goes on from the answer of another has a matrix of the same structure, and
   pairs that were good there are mostly good here. A caller gives an order before a solve and takes one after it
   (`pivot_orders.py`); the first matrix that its thread then analyses is meant. */

/* Least entry of a given pair, as part of the largest in its dual row. Pairs are chosen with a tenth, but within one
   solve some fall below a thousandth. */
static const double LEAST_KEPT = 1e-4;

/* Words before the structure: length of all, rows, hash of the entries' places. */
enum { HEAD = 4 };

static __thread struct {
    int *given, *found;
    int awaits; /* whether no matrix was analysed since */
} keeping;

/* The next matrix tries the pivots of an order that was taken before, NULL for none. */
void give_order(int *given) {
    free(keeping.found);
    keeping.given = given, keeping.found = NULL, keeping.awaits = 1;
}

/* The order of that matrix, where it was not the given one, until one is given again; otherwise NULL. */
const int *taken_order(void) { return keeping.found; }

static uint64_t hash_of(int entries, const int *row, const int *column) {
    uint64_t hash = UINT64_C(14695981039346656037);
    for (int k = 0; k < entries; k++)
        hash = (hash ^ ((uint64_t)row[k] << 32 | (uint64_t)column[k])) * UINT64_C(1099511628211);
    return hash;
}

/* Whether the pairs of a structure are good for other numbers; 0 without memory. */
static int has_good_pairs(int n, const Structure *s, const int *row, const int *column, const double *value) {
    double *largest = calloc(2 * (size_t)n + 1, sizeof *largest), *paired = largest + n;
    int good = largest != NULL;
    for (int i = 0; good && i < n; i++) paired[i] = -1.0;
    for (int k = 0; good && k < s->entries; k++) {
        int dual = greater(row[k], column[k]) - 1, primal = lesser(row[k], column[k]) - 1;
        if (dual < s->primal || primal >= s->primal) continue;
        int one = s->position[primal], two = s->position[dual];
        largest[dual] = fmax(largest[dual], fabs(value[k]));
        if (s->companion[two] == one || (s->width[one] == 2 && two == one + 1))
            paired[dual] = fmax(paired[dual], fabs(value[k]));
    }
    for (int i = 0; good && i < n; i++) good = paired[i] < 0.0 || paired[i] >= LEAST_KEPT * largest[i];
    free(largest);
    return good;
}

/* The given structure where it serves, NULL where not. */
static int *given_structure(int n, int entries, const int *row, const int *column, const double *value,
                            long long *length) {
    uint64_t hash = 0;
    if (!keeping.awaits || !keeping.given || keeping.given[1] != n) return NULL;
    memcpy(&hash, keeping.given + 2, sizeof hash);
    if (hash != hash_of(entries, row, column)) return NULL;
    Structure s = structure_in(n, keeping.given + HEAD);
    if (s.entries != entries || !has_good_pairs(n, &s, row, column, value)) return NULL;
    *length = keeping.given[0] - HEAD;
    return keeping.given + HEAD;
}

/* Note the structure of the first matrix for who takes it, unless it was given; without memory there is none. */
static void note(int n, int entries, const int *row, const int *column, const int *structure, long long length,
                 int is_given) {
    int is_first = keeping.awaits;
    keeping.awaits = 0;
    if (!is_first || is_given || length > INT_MAX - HEAD) return;
    keeping.found = malloc(((size_t)length + HEAD) * sizeof *keeping.found);
    if (!keeping.found) return;
    uint64_t hash = hash_of(entries, row, column);
    keeping.found[0] = (int)length + HEAD, keeping.found[1] = n;
    memcpy(keeping.found + 2, &hash, sizeof hash);
    memcpy(keeping.found + HEAD, structure, (size_t)length * sizeof *structure);
}
