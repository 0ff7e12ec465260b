/* Pivots of a sparse symmetric matrix for an LDL^T that keeps to them whatever the numbers.

   The matrix is IPOPT's: variables and slacks first (primal rows), multipliers of the constraints last (dual rows),

       [ W + S   J^T ]
       [   J    -C   ]      S, C diagonal, C mostly zero.

   Each dual row is paired with a primal row by a large entry: the two make one pivot, which is regular however small
   the diagonal is. Pairs and single rows are the nodes of a graph, which is long and thin, since a stage of the motion
   touches the next one only: its levels (distances from the first node) are eliminated from the far end, each by
   minimum degree. Inequalities, each a pair with its slack, come before all. */

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* Least entry that makes a pair, as part of the largest in its dual row: first this, then this. */
static const double LEAST_ENTRY[2] = {0.1, 1e-3};

static int lesser(int a, int b) { return a < b ? a : b; }
static int greater(int a, int b) { return a < b ? b : a; }

/* Indices of the entries sorted by key: those of key i are sequence[start[i]] .. sequence[start[i + 1] - 1]; entries
   with a negative key are left out. */
static void sort_by(int entries, const int *key, int keys, int *start, int *sequence) {
    memset(start, 0, ((size_t)keys + 1) * sizeof *start);
    for (int k = 0; k < entries; k++)
        if (key[k] >= 0) start[key[k] + 1]++;
    for (int i = 0; i < keys; i++) start[i + 1] += start[i];
    for (int k = 0; k < entries; k++)
        if (key[k] >= 0) sequence[start[key[k]]++] = k;
    for (int i = keys; i > 0; i--) start[i] = start[i - 1];
    start[0] = 0;
}

/* ---- pairs ---- */

typedef struct {
    int primal, dual;      /* number of rows */
    int *start, *sequence; /* entries of each dual row in primal columns */
    int *column;           /* of each entry */
    double *size;          /* of each entry, as part of the largest in its row */
    int *degree;           /* entries of each column */
    int *row_of;           /* dual row that each column is paired with, -1 for none */
    int *column_of;        /* column that each dual row is paired with, -1 for none */
    int *reached, *queue;  /* of a search: the row from which each column was reached, -1 for none; rows to look at */
    int *visited;          /* of a search: columns in the order in which they were reached */
} Pairs;

/* Pair a dual row with the last free column. Variables are numbered along the motion, so for the equations of a stage this
   is what they give at its end: with what stands before, its multiplier is free of what comes after. */
static void pair_at_once(Pairs *p, int row, double least) {
    int best = -1;
    for (int q = p->start[row]; q < p->start[row + 1]; q++) {
        int k = p->sequence[q], c = p->column[k];
        if (p->size[k] < least || p->row_of[c] >= 0) continue;
        best = greater(best, c);
    }
    if (best >= 0) p->row_of[best] = row, p->column_of[row] = best;
}

/* Pair a dual row by moving others to other columns: the shortest augmenting path. What a search without success has
   reached stays marked: no later path leads over it, so all such searches together look at each entry once. */
static void pair_by_moving(Pairs *p, int row, double least) {
    int next = 0, last = 0, count = 0;
    p->queue[last++] = row;
    while (next < last) {
        int from = p->queue[next++];
        for (int q = p->start[from]; q < p->start[from + 1]; q++) {
            int k = p->sequence[q], c = p->column[k];
            if (p->size[k] < least || p->reached[c] >= 0) continue;
            p->reached[c] = from, p->visited[count++] = c;
            if (p->row_of[c] >= 0) {
                p->queue[last++] = p->row_of[c];
                continue;
            }
            while (c >= 0) {
                int mover = p->reached[c], left = p->column_of[mover];
                p->row_of[c] = mover, p->column_of[mover] = c;
                c = left;
            }
            while (count) p->reached[p->visited[--count]] = -1;
            return;
        }
    }
}

static void find_pairs(Pairs *p) {
    for (int c = 0; c < p->primal; c++) p->row_of[c] = -1;
    for (int d = 0; d < p->dual; d++) p->column_of[d] = -1;
    for (int pass = 0; pass < 2; pass++) {
        for (int c = 0; c < p->primal; c++) p->reached[c] = -1;
        for (int d = 0; d < p->dual; d++)
            if (p->column_of[d] < 0) pair_at_once(p, d, LEAST_ENTRY[pass]);
        for (int d = 0; d < p->dual; d++)
            if (p->column_of[d] < 0) pair_by_moving(p, d, LEAST_ENTRY[pass]);
    }
}

/* ---- levels ---- */

typedef struct {
    int nodes;
    const int *start, *other; /* neighbours of each node, some more than once */
    const int *inequality;    /* whether a node is one; no two of them are neighbours */
    const int *alone;         /* whether a node is a single row */
    int *level, *seen;        /* of nodes that are none; of those that are: whether they were looked at */
    int *first, *member;      /* nodes by level */
    int *local;               /* place of a node in the front */
    int levels, width;        /* words of a row of the front */
    uint64_t *front;          /* which nodes are neighbours, of two levels that follow each other: a row of bits each */
    uint64_t *clique;         /* room for one more row */
} Levels;

static uint64_t *bits(const Levels *g, int node) { return g->front + (size_t)g->local[node] * g->width; }

static void join(const Levels *g, int a, int b) {
    if (a == b) return;
    bits(g, a)[g->local[b] / 64] |= UINT64_C(1) << (g->local[b] % 64);
    bits(g, b)[g->local[a] / 64] |= UINT64_C(1) << (g->local[a] % 64);
}

/* Make some nodes neighbours of each other. */
static void join_all(const Levels *g, const int *node, int count) {
    memset(g->clique, 0, (size_t)g->width * sizeof *g->clique);
    for (int k = 0; k < count; k++) g->clique[g->local[node[k]] / 64] |= UINT64_C(1) << (g->local[node[k]] % 64);
    for (int k = 0; k < count; k++) {
        uint64_t *row = bits(g, node[k]);
        for (int word = 0; word < g->width; word++) row[word] |= g->clique[word];
        row[g->local[node[k]] / 64] &= ~(UINT64_C(1) << (g->local[node[k]] % 64));
    }
}

/* Distances from the first node that is not reached yet, and so on; an inequality makes neighbours of its own. */
static void find_levels(Levels *g, int *queue) {
    int last = 0, next = 0;
    for (int i = 0; i < g->nodes; i++) g->level[i] = -1, g->seen[i] = 0;
    g->levels = 0;
    for (int from = 0; from < g->nodes; from++) {
        if (g->inequality[from] || g->level[from] >= 0) continue;
        g->level[from] = g->levels, queue[last++] = from;
        for (; next < last; next++) {
            int i = queue[next], beyond = g->level[i] + 1;
            for (int q = g->start[i]; q < g->start[i + 1]; q++) {
                int j = g->other[q];
                if (!g->inequality[j]) {
                    if (g->level[j] < 0) g->level[j] = beyond, queue[last++] = j;
                } else if (!g->seen[j]) {
                    g->seen[j] = 1;
                    for (int r = g->start[j]; r < g->start[j + 1]; r++)
                        if (g->level[g->other[r]] < 0) g->level[g->other[r]] = beyond, queue[last++] = g->other[r];
                }
            }
        }
        if (last) g->levels = g->level[queue[last - 1]] + 1;
    }
}

/* Make neighbours of what the entries join at a level, as far as no higher level has. */
static void gather(const Levels *g, int level) {
    for (int k = g->first[level]; k < g->first[level + 1]; k++) {
        int i = g->member[k];
        for (int q = g->start[i]; q < g->start[i + 1]; q++) {
            int j = g->other[q];
            if (!g->inequality[j]) {
                if (g->level[j] <= level) join(g, i, j);
            } else if (g->seen[j]) {
                g->seen[j] = 0;
                join_all(g, g->other + g->start[j], g->start[j + 1] - g->start[j]);
            }
        }
    }
}

/* Bits of some words, two by two, four by four and so on: compilers call a function for each where a processor need not
   have an instruction for it. */
static int count_of(const uint64_t *row, int width) {
    int count = 0;
    for (int k = 0; k < width; k++) {
        uint64_t x = row[k] - (row[k] >> 1 & UINT64_C(0x5555555555555555));
        x = (x & UINT64_C(0x3333333333333333)) + (x >> 2 & UINT64_C(0x3333333333333333));
        count += (int)(((x + (x >> 4)) & UINT64_C(0x0f0f0f0f0f0f0f0f)) * UINT64_C(0x0101010101010101) >> 56);
    }
    return count;
}

/* Whether a node is eliminated before another of its level: pairs before single rows, and that of fewer neighbours. What
   a single row touches becomes neighbours, multipliers among them; a pair leaves those apart, since the multiplier's
   diagonal is zero. */
static int comes_before(const Levels *g, int one, int other, const int *degree) {
    if (g->alone[one] != g->alone[other]) return g->alone[other];
    return degree[one] < degree[other];
}

/* Eliminate the nodes of a level one after the other; returns the next place in the sequence. `at`: node at each place of
   the front. */
static int eliminate_level(const Levels *g, int level, const int *at, int *degree, int *sequence, int next) {
    int *left = g->member + g->first[level], count = g->first[level + 1] - g->first[level];
    for (int k = 0; k < count; k++) degree[left[k]] = count_of(bits(g, left[k]), g->width);
    for (; count > 0; count--) {
        int best = 0;
        for (int k = 1; k < count; k++)
            if (comes_before(g, left[k], left[best], degree)) best = k;
        int pivot = left[best];
        uint64_t *own = bits(g, pivot), mask = UINT64_C(1) << (g->local[pivot] % 64);
        for (int word = 0; word < g->width; word++)
            for (uint64_t rest = own[word]; rest; rest &= rest - 1) {
                int bit = __builtin_ctzll(rest), place = 64 * word + bit;
                uint64_t *row = g->front + (size_t)place * g->width;
                for (int k = 0; k < g->width; k++) row[k] |= own[k];
                row[word] &= ~(UINT64_C(1) << bit), row[g->local[pivot] / 64] &= ~mask;
                if (g->level[at[place]] == level) degree[at[place]] = count_of(row, g->width);
            }
        memset(own, 0, (size_t)g->width * sizeof *own);
        sequence[next++] = pivot;
        left[best] = left[count - 1];
    }
    return next;
}

/* The order of the nodes; 0 without memory. */
static int order_nodes(int nodes, const int *start, const int *other, const int *inequality, const int *alone,
                       int *sequence) {
    size_t size = (size_t)nodes + 1;
    int *whole = malloc(7 * size * sizeof *whole), next = 0, most[2] = {0, 0}, done = 0;
    if (!whole) return 0;
    memset(whole, 0, 7 * size * sizeof *whole);
    Levels g = {nodes, start, other, inequality, alone, whole, whole + size, whole + 2 * size, whole + 3 * size,
                whole + 4 * size, 0, 0, NULL, NULL};
    int *degree = whole + 5 * size, *at = whole + 6 * size;
    find_levels(&g, at);
    for (int i = 0; i < nodes; i++)
        if (inequality[i]) sequence[next++] = i;
    sort_by(nodes, g.level, g.levels, g.first, g.member);
    for (int l = 0; l < g.levels; l++) most[l % 2] = greater(most[l % 2], g.first[l + 1] - g.first[l]);
    for (int l = 0; l < g.levels; l++)
        for (int k = g.first[l]; k < g.first[l + 1]; k++) g.local[g.member[k]] = k - g.first[l] + (l % 2 ? most[0] : 0);
    g.width = (most[0] + most[1] + 63) / 64;
    g.front = calloc((size_t)(most[0] + most[1] + 1) * (size_t)g.width + 1, sizeof *g.front);
    g.clique = g.front + (size_t)(most[0] + most[1]) * (size_t)g.width;
    for (int l = g.levels - 1; g.front && l >= 0; l--) {
        for (int below = l; below >= 0 && below >= l - 1; below--)
            for (int k = g.first[below]; k < g.first[below + 1]; k++) at[g.local[g.member[k]]] = g.member[k];
        gather(&g, l);
        next = eliminate_level(&g, l, at, degree, sequence, next);
    }
    done = g.front != NULL;
    free(g.front);
    free(whole);
    return done;
}

/* ---- order ---- */

/* Number of primal rows: dual rows are the last, and none shares an entry with another. The last slack shares one with
   the last of them, so the count is exact where there is an inequality. */
static int primal_rows(int entries, const int *row, const int *column) {
    int count = 0;
    for (int k = 0; k < entries; k++)
        if (row[k] != column[k]) count = greater(count, lesser(row[k], column[k]));
    return count;
}

/* Pair the rows of a matrix and order the pivots. A row with entries in its partner only, as a slack has, makes no
   column of the factor: it comes at the end, and its width is -1 - position of the partner. */
static int order_pivots(int n, int entries, const int *row, const int *column, const double *value, int *position,
                        int *width) {
    size_t rows = (size_t)n + 1, all = (size_t)entries + 1;
    int *whole = malloc((13 * rows + 6 * all) * sizeof *whole);
    int *key = whole, *other = key + 2 * all, *part = other + 4 * all;
    double *size = malloc((all + rows) * sizeof *size), *largest = size + all;
    int primal = primal_rows(entries, row, column), nodes = 0, last = 0, end = n, found = 0;
    if (whole && size) {
        Pairs p = {primal,          n - primal,      part,            other + all,     other,          size,
                   part + rows, part + 2 * rows, part + 3 * rows, part + 4 * rows, part + 5 * rows, part + 6 * rows};
        int *node = part + 7 * rows, *first = part + 8 * rows, *inequality = part + 9 * rows;
        int *start = part + 10 * rows, *sequence = part + 11 * rows, ends = 0;
        int *alone = part + 12 * rows;
        memset(p.degree, 0, rows * sizeof *p.degree);
        memset(largest, 0, rows * sizeof *largest);
        for (int k = 0; k < entries; k++) {
            int d = greater(row[k], column[k]) - 1 - primal, c = lesser(row[k], column[k]) - 1;
            key[k] = d >= 0 && c < primal ? d : -1, other[k] = c;
            if (row[k] != column[k]) p.degree[row[k] - 1]++, p.degree[column[k] - 1]++;
            if (key[k] >= 0) largest[d] = fmax(largest[d], fabs(value[k]));
        }
        for (int k = 0; k < entries; k++) size[k] = key[k] < 0 ? 0.0 : fabs(value[k]) / fmax(largest[key[k]], 1e-300);
        sort_by(entries, key, p.dual, p.start, p.sequence);
        find_pairs(&p);

        for (int i = 0; i < n; i++) {
            int partner = i < primal ? p.row_of[i] : p.column_of[i - primal];
            int slack = partner >= 0 && p.degree[i < primal ? i : partner] == 1;
            if (i < primal && slack) {
                node[i] = -1;
                continue;
            }
            if (i < primal || partner < 0 || slack)
                inequality[nodes] = slack, alone[nodes] = partner < 0, first[nodes] = i, node[i] = nodes++;
            else
                node[i] = node[partner];
        }
        for (int k = 0; k < entries; k++) {
            int a = node[row[k] - 1], b = node[column[k] - 1];
            if (a == b || a < 0 || b < 0) continue;
            key[ends] = a, other[ends++] = b;
            key[ends] = b, other[ends++] = a;
        }
        int *by_node = other + 2 * all;
        sort_by(ends, key, nodes, start, by_node);
        for (int q = 0; q < ends; q++) key[q] = other[by_node[q]];
        found = order_nodes(nodes, start, key, inequality, alone, sequence);
        for (int i = 0; found && i < nodes; i++) {
            int one = first[sequence[i]], two = one < primal ? p.row_of[one] : -1;
            width[last] = two < 0 ? 1 : 2;
            position[one] = last++;
            if (two >= 0) width[last] = 0, position[primal + two] = last++;
        }
        for (int i = 0; found && i < primal; i++)
            if (p.row_of[i] >= 0 && p.degree[i] == 1) {
                position[i] = --end;
                width[end] = -1 - position[primal + p.row_of[i]];
            }
    }
    free(whole);
    free(size);
    return found;
}
