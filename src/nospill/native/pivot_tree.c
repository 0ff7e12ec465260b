/* Elimination tree of pivots whose order is given. They are renumbered so that each comes after its descendants, and
   right before its parent where it can; what they fill in stays the same.

   A pivot fills in rows, not other pivots: of a pair it may reach one row alone. The multipliers of a stage's equations
   stay untouched by the stage after it, whose variables are eliminated before. */

typedef struct {
    int rows, pivots;
    int *node;           /* of each position, -1 for a slack that is eliminated with another row */
    int *wide;           /* rows of each pivot */
    int *parent, *count; /* of the tree; rows below */
    int *start, *other;  /* earlier pivots that each row has entries in, some more than once */
    int *begin, *below;  /* later rows that each fills in, ascending */
    int *mark;
} Tree;

/* Later rows of every pivot, by row subtrees: first the parents and how many there are, then the lists. */
static void climb(Tree *t, int with_lists) {
    for (int i = 0; i < t->pivots; i++) t->mark[i] = -1;
    if (!with_lists)
        for (int i = 0; i < t->pivots; i++) t->parent[i] = -1, t->count[i] = 0;
    for (int r = 0; r < t->rows; r++) {
        int own = t->node[r];
        t->mark[own] = r;
        for (int q = t->start[r]; q < t->start[r + 1]; q++)
            for (int i = t->other[q]; t->mark[i] != r; i = t->parent[i]) {
                if (t->parent[i] < 0) t->parent[i] = own;
                if (with_lists) t->below[t->begin[i]++] = r;
                t->count[i] += !with_lists;
                t->mark[i] = r;
            }
    }
}

/* Entries between pivots by the later row. */
static void neighbours(Tree *t, int entries, const int *row, const int *column, const int *position, int *key, int *lo,
                       int *sequence) {
    for (int k = 0; k < entries; k++) {
        int i = position[row[k] - 1], j = position[column[k] - 1], a = t->node[i], b = t->node[j];
        key[k] = a < 0 || b < 0 || a == b ? -1 : greater(i, j), lo[k] = lesser(a, b);
    }
    sort_by(entries, key, t->rows, t->start, sequence);
    for (int q = 0; q < t->start[t->rows]; q++) t->other[q] = lo[sequence[q]];
}

typedef struct {
    int parent, count, node;
} Child;

static int compare(const void *one, const void *two) {
    const Child *a = one, *b = two;
    if (a->parent != b->parent) return a->parent < b->parent ? -1 : 1;
    if (a->count != b->count) return a->count < b->count ? -1 : 1;
    return a->node < b->node ? -1 : a->node > b->node;
}

/* Sequence of the pivots with every one after its descendants, of several children that of the most rows last. */
static void postorder(const Tree *t, Child *child, int *begin, int *stack, int *sequence) {
    int next = 0, depth = 0;
    for (int i = 0; i < t->pivots; i++) /* roots are children of one pivot more */
        child[i] = (Child){t->parent[i] < 0 ? t->pivots : t->parent[i], t->count[i], i};
    qsort(child, (size_t)t->pivots, sizeof *child, compare);
    for (int i = 0; i <= t->pivots + 1; i++) begin[i] = 0;
    for (int i = 0; i < t->pivots; i++) begin[child[i].parent + 1]++;
    for (int i = 0; i <= t->pivots; i++) begin[i + 1] += begin[i];
    for (int r = begin[t->pivots]; r < t->pivots; r++) { /* begin[i] moves on with the children that are done */
        stack[depth++] = child[r].node;
        while (depth) {
            int i = stack[depth - 1];
            if (begin[i] < t->pivots && child[begin[i]].parent == i)
                stack[depth++] = child[begin[i]++].node;
            else
                sequence[next++] = i, depth--;
        }
    }
}

/* Number the pivots, and the rows with them, in a sequence. */
static void renumber(Tree *t, int n, const int *sequence, int *position, int *width, int *scratch) {
    int *fresh = scratch, *at = scratch + n, next = 0, *wide = at + n;
    for (int k = 0; k < t->pivots; k++) fresh[sequence[k]] = k, wide[k] = t->wide[sequence[k]];
    for (int k = 0, from = 0; k < t->pivots; from += t->wide[k++]) at[fresh[k]] = from;
    int *moved = wide + n;
    for (int i = 0; i < n; i++) moved[i] = i;
    for (int k = 0; k < t->pivots; k++)
        for (int own = 0; own < wide[k]; own++) moved[at[k] + own] = next++;
    for (int i = next; i < n; i++) width[i] = -1 - moved[-1 - width[i]];
    for (int i = 0; i < n; i++) position[i] = moved[position[i]];
    next = 0;
    for (int k = 0; k < t->pivots; k++) {
        t->wide[k] = wide[k];
        for (int own = 0; own < wide[k]; own++) width[next] = own ? 0 : wide[k], t->node[next++] = k;
    }
}
