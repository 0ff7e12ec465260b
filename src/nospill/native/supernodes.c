/* Structure of the factor: columns with nearly the same rows are one supernode, a dense panel. A pivot joins the panel
   before it where it is the parent of that and few places of the panel stay zero, or where both are leaves of the tree
   with the same rows, as the inequalities of a stage are. */

/* Most places of a panel that may be zero, as part of all. */
static const double MOST_ZEROS = 0.1;

/* Columns eliminated one by one before the next ones of a panel are brought up to date; of a panel of leaves, between
   which nothing stands, the most. */
enum { BLOCK_COLUMNS = 8 };

typedef struct {
    int entries, columns, panels, rows, targets, locals, factor, most, primal; /* sizes; most: room for work */
    int *position;  /* of each row of the matrix; slacks that are eliminated with their multiplier come last */
    int *width;     /* of the pivot at each position: 1, 2, 0 at the second row of a pair */
    int *companion; /* position of the slack that is eliminated with the pivot, -1 for none */
    int *place;     /* of each entry, in the factor; a slack's coupling and diagonal come after all panels */
    int *first;     /* column of each panel */
    int *list;      /* where the rows below each panel begin in `row` */
    int *row;       /* positions */
    int *panel;     /* where each begins in the factor; by columns, the panel's own rows above those of the list */
    int *update;    /* where each panel's targets begin */
    int *target;    /* the panel, and the first of the rows that are columns there */
    int *local;     /* for each target, from that row on: rows in the target's panel */
    int *where;     /* where the rows of each target begin in `local` */
} Structure;

enum { SIZES = 9 };

/* Lay out the structure in an array whose first numbers are its sizes; returns the array's length. */
static long long lay_out(Structure *s, int n, int *array) {
    long long next = SIZES;
    int **part[] = {&s->position, &s->width, &s->companion, &s->place,  &s->first, &s->list,
                    &s->panel,    &s->update, &s->row,      &s->target, &s->where, &s->local};
    int size[] = {n,           n,           n,       s->entries,     s->panels + 1, s->panels + 1, s->panels + 1,
                  s->panels + 1, s->rows, 2 * s->targets, s->targets, s->locals};
    for (int k = 0; k < 12; k++) {
        if (array) *part[k] = array + next;
        next += size[k];
    }
    return next;
}

/* ---- panels ---- */

/* Whether two pivots are leaves of the tree, without earlier neighbours, that fill in the same rows: nothing stands
   between them, and they may be one panel. `at`: the first row of each. */
static int are_alike(const Tree *t, const int *at, int one, int two) {
    int count = t->count[one], leaves = t->start[at[one]] == t->start[at[two + 1]];
    return leaves && count > 0 && count == t->count[two] &&
           !memcmp(t->below + t->begin[one], t->below + t->begin[two], (size_t)count * sizeof *t->below);
}

/* Divide the pivots into panels, the first pivot of each in `first`; below a panel are the rows below its last pivot.
   Returns the number of panels. */
static int divide_into_panels(const Tree *t, const int *at, int *first) {
    int panels = 0, columns = 0;
    long long held = 0;
    for (int k = 0; k < t->pivots; k++) {
        long long wide = t->wide[k], all = columns + wide, rows = t->count[k];
        long long alone = wide * (wide + 1) / 2 + wide * rows, size = all * (all + 1) / 2 + all * rows;
        int dense = (double)(size - held - alone) < MOST_ZEROS * (double)size;
        if (k > 0 && ((t->parent[k - 1] == k && dense) || (all <= BLOCK_COLUMNS && are_alike(t, at, k - 1, k))))
            columns = (int)all, held += alone;
        else
            first[panels++] = k, columns = (int)wide, held = alone;
    }
    first[panels] = t->pivots;
    return panels;
}

/* ---- all of it ---- */

/* Place in the factor of position i (a row) and j <= i (a column). */
static int place_of(const Structure *s, const int *panel_of, int i, int j) {
    int p = panel_of[j], own = s->first[p + 1] - s->first[p], height = own + s->list[p + 1] - s->list[p], at;
    if (i < s->first[p + 1])
        at = i - s->first[p];
    else {
        int low = s->list[p], high = s->list[p + 1] - 1;
        while (low < high) {
            int middle = (low + high) / 2;
            if (s->row[middle] < i)
                low = middle + 1;
            else
                high = middle;
        }
        at = own + low - s->list[p];
    }
    return s->panel[p] + (j - s->first[p]) * height + at;
}

/* Where the rows of each panel go in the panels that they are columns of. With no arrays yet, how many there are. */
static void find_targets(Structure *s, const int *panel_of, int counting) {
    s->targets = s->locals = 0;
    for (int p = 0; p < s->panels; p++) {
        if (!counting) s->update[p] = s->targets;
        for (int k = s->list[p]; k < s->list[p + 1];) {
            int t = panel_of[s->row[k]], from = k, below = s->list[t], own = s->first[t + 1] - s->first[t];
            if (!counting)
                s->target[2 * s->targets] = t, s->target[2 * s->targets + 1] = k - s->list[p],
                s->where[s->targets] = s->locals;
            for (; k < s->list[p + 1] && s->row[k] < s->first[t + 1]; k++) continue;
            for (int i = from; !counting && i < s->list[p + 1]; i++) {
                if (i < k)
                    s->local[s->locals + i - from] = s->row[i] - s->first[t];
                else {
                    while (s->row[below] < s->row[i]) below++;
                    s->local[s->locals + i - from] = own + below - s->list[t];
                }
            }
            s->targets++, s->locals += s->list[p + 1] - from;
        }
    }
    if (!counting) s->update[s->panels] = s->targets;
}

/* The structure, laid out in an array that the caller frees, NULL without memory. `position`, `width`: as order_pivots
   leaves them. */
static int *structure_of(int n, int entries, const int *row, const int *column, const int *position, const int *width,
                         long long *length) {
    size_t rows = (size_t)n + 2, all = (size_t)entries + 1;
    int *whole = malloc((15 * rows + 4 * all) * sizeof *whole), *lists = NULL, *array = NULL;
    Child *child = malloc(rows * sizeof *child);
    Structure s = {.entries = entries, .primal = primal_rows(entries, row, column)};
    if (!whole || !child) goto done;
    int *own_position = whole, *own_width = whole + rows, *sequence = whole + 2 * rows, *at = whole + 3 * rows;
    int *scratch = whole + 4 * rows, *key = whole + 15 * rows, *lo = key + all, *by = lo + all; /* scratch: 4 rows */
    Tree t = {0,
              0,
              whole + 8 * rows,
              whole + 9 * rows,
              whole + 10 * rows,
              whole + 11 * rows,
              whole + 12 * rows,
              by + all,
              whole + 13 * rows,
              NULL,
              whole + 14 * rows};
    memcpy(own_position, position, (size_t)n * sizeof *position);
    memcpy(own_width, width, (size_t)n * sizeof *width);
    for (int i = 0; i < n; i++) {
        t.node[i] = own_width[i] > 0 ? t.pivots++ : own_width[i] == 0 ? t.pivots - 1 : -1;
        if (own_width[i] > 0) t.wide[t.pivots - 1] = own_width[i];
        s.columns += own_width[i] >= 0;
    }
    t.rows = s.columns;
    neighbours(&t, entries, row, column, own_position, key, lo, by);
    climb(&t, 0);
    postorder(&t, child, t.begin, scratch, sequence);
    renumber(&t, n, sequence, own_position, own_width, scratch);
    neighbours(&t, entries, row, column, own_position, key, lo, by);
    climb(&t, 0);
    t.begin[0] = 0;
    for (int i = 0; i < t.pivots; i++) t.begin[i + 1] = t.begin[i] + t.count[i];
    t.below = lists = malloc(((size_t)t.begin[t.pivots] + 1) * sizeof *lists);
    if (!lists) goto done;
    climb(&t, 1);
    for (int i = t.pivots; i > 0; i--) t.begin[i] = t.begin[i - 1];
    t.begin[0] = 0;

    int *first = sequence, *panel_of = scratch;
    for (int i = 0, from = 0; i < t.pivots; from += t.wide[i++]) at[i] = from; /* first position */
    at[t.pivots] = s.columns;
    s.panels = divide_into_panels(&t, at, first);
    for (int p = 0; p < s.panels; p++) s.rows += t.count[first[p + 1] - 1];
    long long factor = 0;
    s.first = scratch + rows, s.list = scratch + 2 * rows, s.panel = scratch + 3 * rows; /* until there is an array */
    s.row = malloc(((size_t)s.rows + 1) * sizeof *s.row);
    if (!s.row) goto done;
    s.first[0] = s.list[0] = s.panel[0] = 0;
    for (int p = 0, next = 0; p < s.panels; p++) {
        int last = first[p + 1] - 1, count = t.count[last];
        memcpy(s.row + next, t.below + t.begin[last], (size_t)count * sizeof *s.row);
        next += count;
        s.first[p + 1] = at[first[p + 1]], s.list[p + 1] = next;
        int own = s.first[p + 1] - s.first[p];
        factor += (long long)own * (own + next - s.list[p]);
        if (factor > INT_MAX / 2) goto free_row;
        s.panel[p + 1] = (int)factor;
        for (int i = s.first[p]; i < s.first[p + 1]; i++) panel_of[i] = p;
    }
    s.factor = (int)factor;
    find_targets(&s, panel_of, 1);
    for (int p = 0; p < s.panels; p++) { /* room: the panel divided by its pivots */
        int own = s.first[p + 1] - s.first[p];
        s.most = greater(s.most, own * (own + s.list[p + 1] - s.list[p]));
    }
    *length = lay_out(&s, n, NULL);
    array = malloc((size_t)*length * sizeof *array);
    if (array) {
        Structure to = s;
        lay_out(&to, n, array);
        memcpy(to.position, own_position, (size_t)n * sizeof *array);
        memcpy(to.width, own_width, (size_t)n * sizeof *array);
        for (int i = 0; i < n; i++) to.companion[i] = -1;
        for (int i = 0; i < n; i++)
            if (own_width[i] < 0) to.companion[-1 - own_width[i]] = i;
        memcpy(to.first, s.first, ((size_t)s.panels + 1) * sizeof *array);
        memcpy(to.list, s.list, ((size_t)s.panels + 1) * sizeof *array);
        memcpy(to.panel, s.panel, ((size_t)s.panels + 1) * sizeof *array);
        memcpy(to.row, s.row, (size_t)s.rows * sizeof *array);
        find_targets(&to, panel_of, 0);
        for (int k = 0; k < entries; k++) {
            int i = own_position[row[k] - 1], j = own_position[column[k] - 1];
            int high = greater(i, j), low = lesser(i, j);
            to.place[k] = high < s.columns ? place_of(&to, panel_of, high, low)
                          : low < s.columns ? s.factor + low : s.factor + high;
        }
        int sizes[SIZES] = {s.entries, s.columns, s.panels, s.rows, s.targets, s.locals, s.factor, s.most, s.primal};
        memcpy(array, sizes, sizeof sizes);
    }
free_row:
    free(s.row);
done:
    free(whole), free(child), free(lists);
    return array;
}

/* The structure in an array that was laid out before. */
static Structure structure_in(int n, int *array) {
    Structure s = {.entries = array[0], .columns = array[1], .panels = array[2], .rows = array[3], .targets = array[4],
                   .locals = array[5], .factor = array[6], .most = array[7], .primal = array[8]};
    lay_out(&s, n, array);
    return s;
}
