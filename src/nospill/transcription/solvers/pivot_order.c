/* Pivots of a sparse symmetric matrix for an LDL^T that keeps to them whatever the numbers.

   The matrix is IPOPT's: variables and slacks first (primal rows), multipliers of the constraints last (dual rows),

       [ W + S   J^T ]
       [   J    -C   ]      S, C diagonal, C mostly zero.

   Each dual row is paired with a primal row by a large entry: the two make one pivot, which is regular however small
   the diagonal is. Pairs and single rows are ordered by approximate minimum degree (AMD, of the library libosqp that
   CasADi brings along). */

#include <math.h>
#include <stdlib.h>
#include <string.h>

long long amd_l_order(long long n, const long long *start, const long long *row, long long *order, double *control,
                      double *info);

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

/* Pair a dual row with the free column of the fewest entries, of several the last. */
static void pair_at_once(Pairs *p, int row, double least) {
    int best = -1;
    for (int q = p->start[row]; q < p->start[row + 1]; q++) {
        int k = p->sequence[q], c = p->column[k];
        if (p->size[k] < least || p->row_of[c] >= 0) continue;
        if (best < 0 || p->degree[c] < p->degree[best] || (p->degree[c] == p->degree[best] && c > best)) best = c;
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
    int *whole = malloc((9 * rows + 3 * all) * sizeof *whole);
    int *key = whole, *other = key + all, *part = other + 2 * all;
    double *size = malloc((all + rows) * sizeof *size), *largest = size + all;
    long long *start = malloc((2 * rows + all) * sizeof *start), *pattern = start + rows, *sequence = pattern + all;
    int primal = primal_rows(entries, row, column), nodes = 0, last = 0, end = n, found = 0;
    if (whole && size && start) {
        Pairs p = {primal,          n - primal,      part,            other + all,     other,          size,
                   part + rows, part + 2 * rows, part + 3 * rows, part + 4 * rows, part + 5 * rows, part + 6 * rows};
        int *node = part + 7 * rows, *first = part + 8 * rows;
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
            int partner = i < primal ? -1 : p.column_of[i - primal];
            if (partner < 0 || p.degree[partner] == 1)
                first[nodes] = i, node[i] = nodes++;
            else
                node[i] = node[partner];
        }
        for (int k = 0; k < entries; k++) {
            int a = node[row[k] - 1], b = node[column[k] - 1];
            key[k] = a == b ? -1 : b, other[k] = a;
        }
        sort_by(entries, key, nodes, p.start, p.sequence);
        for (int i = 0; i <= nodes; i++) start[i] = p.start[i];
        for (int q = 0; q < p.start[nodes]; q++) pattern[q] = other[p.sequence[q]];
        found = amd_l_order(nodes, start, pattern, sequence, NULL, NULL) >= 0;
        for (int i = 0; found && i < nodes; i++) {
            int one = first[sequence[i]], two = one < primal ? p.row_of[one] : -1;
            if (two >= 0 && p.degree[one] == 1) continue;
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
    free(start);
    return found;
}
