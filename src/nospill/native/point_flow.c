/* The nonlinear flow of one container of any section as potential_flow/nonlinear.py has it, four points of its surface in
   a vector. The bottom's part of a lean has the form of what comes back from the bottom, exp(-k z), and is added to that.
   What fills the last vector has no weight. */

typedef struct {
    int vectors, modes;                           /* of points; of the surface */
    const double *wave_number, *fall, *damping;   /* by modes: k, exp(-k h), of the pressure per rate, times the norm */
    const double *lean;                           /* by modes, along x and y: shares in the functions x and y */
    const four *x, *y, *weight;                   /* by vectors of points */
    const four *turn;                             /* velocity per turn past the container along x and y, and potential */
    const four *shape, *slope;                    /* by modes and vectors; slopes along x, then along y */
    double greatest;                              /* height from which on there is no flow */
} Section;

typedef struct {
    four *height, *steep[2], *velocity[3], *lift; /* by vectors */
    four *value;                                  /* by modes and vectors */
    four *matrix, *inverse, *pushed;              /* in which all four places have the same */
    double *stages;
} Points;

INLINE four sum_of(four parts) {
    const double sum = (parts[0] + parts[1]) + (parts[2] + parts[3]);
    return (four){sum, sum, sum, sum};
}

INLINE void point_surface(const Section *b, const Points *o, const double *state) {
    for (int p = 0; p < b->vectors; p++) o->height[p] = o->steep[0][p] = o->steep[1][p] = (four){0.0};
    for (int j = 0; j < b->modes; j++) {
        const four *shape = b->shape + j * b->vectors, *slope = b->slope + j * b->vectors;
        const four *other = slope + b->modes * b->vectors;
        for (int p = 0; p < b->vectors; p++) {
            o->height[p] += state[j] * shape[p];
            o->steep[0][p] += state[j] * slope[p];
            o->steep[1][p] += state[j] * other[p];
        }
    }
    for (int p = 0; p < b->vectors; p++) { /* not a number where there is no flow */
        mask high = (mask)(o->height[p] > b->greatest) | (mask)(o->height[p] < -b->greatest);
        o->height[p] = (four)((mask)o->height[p] | high);
    }
}

/* Velocities past the container at the surface, values there per amplitude, and what leans press. */
INLINE void point_fields(const Section *b, const Points *o, const double *potential, const double *row) {
    const double lean[2] = {row[1], -row[0]}, lean_rate[2] = {row[4], -row[3]};
    for (int p = 0; p < b->vectors; p++) {
        for (int a = 0; a < 2; a++) o->velocity[a][p] = row[2] * b->turn[a * b->vectors + p];
        o->velocity[2][p] = 2.0 * (b->x[p] * lean[0] + b->y[p] * lean[1]);
        o->lift[p] = (b->x[p] * lean_rate[0] + b->y[p] * lean_rate[1]) * o->height[p];
    }
    for (int j = 0; j < b->modes; j++) {
        const four *shape = b->shape + j * b->vectors, *slope = b->slope + j * b->vectors;
        const four *other = slope + b->modes * b->vectors;
        const double k = b->wave_number[j], fall = b->fall[j], share = 1.0 / (1.0 + fall * fall);
        const double own = share * potential[j], leaning = 2.0 * fall / k, *part = b->lean + 2 * j;
        const double leaned = leaning * (part[0] * lean[0] + part[1] * lean[1]);
        const double pressed = leaning * (part[0] * lean_rate[0] + part[1] * lean_rate[1]);
        const double back = fall * fall * own + leaned;
        four *value = o->value + j * b->vectors;
        for (int p = 0; p < b->vectors; p++) {
            four up, down;
            powers_of_two(o->height[p] * (k * 1.4426950408889634), &up, &down); /* exp(k eta), exp(-k eta) */
            const four along = own * up + back * down;
            o->velocity[0][p] += slope[p] * along;
            o->velocity[1][p] += other[p] * along;
            o->velocity[2][p] += k * shape[p] * (own * up - back * down);
            o->lift[p] += pressed * shape[p] * down;
            value[p] = share * shape[p] * (up + fall * fall * down);
        }
    }
}

/* What goes through the surface, in place of the rise, and the pressure over density there, in place of the lift; both
   with the weight of their points. */
INLINE void point_conditions(const Section *b, const Points *o, const double *row) {
    const double *omega = row, *force = row + 6;
    const four *potential = b->turn + 2 * b->vectors;
    for (int p = 0; p < b->vectors; p++) {
        const four x = b->x[p], y = b->y[p], height = o->height[p];
        const four wall[3] = {omega[1] * height - omega[2] * y, omega[2] * x - omega[0] * height,
                              omega[0] * y - omega[1] * x};
        four squares = {0.0};
        for (int a = 0; a < 3; a++) squares += o->velocity[a][p] * o->velocity[a][p] - wall[a] * wall[a];
        o->lift[p] += force[0] * x + force[1] * y + force[2] * height + row[5] * potential[p] + 0.5 * squares;
        o->lift[p] *= b->weight[p];
        o->velocity[2][p] -= o->steep[0][p] * o->velocity[0][p] + o->steep[1][p] * o->velocity[1][p];
        o->velocity[2][p] *= b->weight[p];
    }
}

/* Sums over points of ROWS rows, b->vectors apart, times `right`. */
#define SUMS(ROWS)                                                                                                     \
    do {                                                                                                               \
        four sums[ROWS];                                                                                               \
        for (int a = 0; a < ROWS; a++) sums[a] = (four){0.0};                                                          \
        for (int p = 0; p < b->vectors; p++)                                                                           \
            for (int a = 0; a < ROWS; a++) sums[a] += left[a * b->vectors + p] * right[p];                             \
        for (int a = 0; a < ROWS; a++) found[a * stride] = sum_of(sums[a]);                                            \
    } while (0)

/* The same of `rows` rows, `stride` apart. */
INLINE void sums_of(const Section *b, int rows, const four *left, const four *right, four *found, int stride) {
    int a = 0;
    for (; a + 4 <= rows; a += 4, left += 4 * b->vectors, found += 4 * stride) SUMS(4);
    for (; a < rows; a++, left += b->vectors, found += stride) SUMS(1);
}

/* Rates of a state, heights and potentials of all modes, along a row of the motion. */
INLINE void point_rates(const Section *b, const Points *o, const double *state, const double *row, double *rate) {
    const int n = b->modes;
    point_surface(b, o, state);
    point_fields(b, o, state + n, row);
    point_conditions(b, o, row);
    sums_of(b, n, o->value, o->velocity[2], o->pushed, 1);
    sums_of(b, n, b->shape, o->lift, o->pushed + n, 1);
    for (int j = 0; j < n; j++) {
        four *value = o->value + j * b->vectors;
        for (int p = 0; p < b->vectors; p++) value[p] *= b->weight[p];
        sums_of(b, n, b->shape, value, o->matrix + j, n);
    }
    factorise(n, o->matrix, o->inverse);
    solve_transposed(n, o->matrix, o->inverse, o->pushed);
    for (int j = 0; j < n; j++) o->pushed[n + j] += b->damping[j] * o->pushed[j];
    solve(n, o->matrix, o->inverse, o->pushed + n);
    for (int j = 0; j < n; j++) rate[j] = o->pushed[j][0], rate[n + j] = -o->pushed[n + j][0];
}

INLINE void point_runge_kutta(const Section *b, const Points *o, const double *rows, double *states, double step,
                              int steps) {
    static const double reach[3] = {0.5, 0.5, 1.0}, share[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    const int n = 2 * b->modes;
    double *rate = o->stages, *there = o->stages + n;
    for (int k = 0; k < steps; k++, rows += 2 * ROW, states += n) {
        double *next = states + n;
        for (int j = 0; j < n; j++) next[j] = there[j] = states[j];
        for (int a = 0; a < 4; a++) {
            point_rates(b, o, there, rows + (a + 1) / 2 * ROW, rate);
            for (int j = 0; j < n; j++) next[j] += step * share[a] * rate[j];
            for (int j = 0; a < 3 && j < n; j++) there[j] = states[j] + step * reach[a] * rate[j];
        }
    }
}

WITH_FMA static void points_with_fma(const Section *b, const Points *o, const double *rows, double *states, double step,
                                     int steps) {
    point_runge_kutta(b, o, rows, states, step, steps);
}

static void points_without_fma(const Section *b, const Points *o, const double *rows, double *states, double step,
                               int steps) {
    point_runge_kutta(b, o, rows, states, step, steps);
}

/* States (steps + 1, 2 modes) of a container, of which the first is given.

   counts: vectors, modes. of_modes: those of Section by modes one after the other, greatest last. of_points: likewise by
   vectors, aligned to 32 bytes. rows (2 steps + 1, 9) at the ends and middles of the steps of `step` s. 0, or 1 where
   memory is short. */
int point_flow_steps(const int *counts, const double *of_modes, const double *of_points, const double *rows,
                     double *states, double step, int steps) {
    const int v = counts[0], n = counts[1];
    Section b = {.vectors = v, .modes = n, .wave_number = of_modes, .fall = of_modes + n, .damping = of_modes + 2 * n};
    b.lean = of_modes + 3 * n, b.greatest = of_modes[5 * n];
    b.x = (const four *)of_points, b.y = b.x + v, b.weight = b.y + v, b.turn = b.weight + v;
    b.shape = b.turn + 3 * v, b.slope = b.shape + n * v;
    void *memory = malloc(((7 + n) * v + n * (n + 4) + 1) * sizeof(four));
    if (!memory) return 1;
    four *left = (four *)(((uintptr_t)memory + sizeof(four) - 1) / sizeof(four) * sizeof(four));
    Points o = {.height = part(&left, v), .steep = {part(&left, v), part(&left, v)}, .lift = part(&left, v)};
    for (int a = 0; a < 3; a++) o.velocity[a] = part(&left, v);
    o.value = part(&left, n * v), o.matrix = part(&left, n * n), o.inverse = part(&left, n);
    o.pushed = part(&left, 2 * n), o.stages = (double *)left; /* 4 n numbers */
    if (HAS_FMA)
        points_with_fma(&b, &o, rows, states, step, steps);
    else
        points_without_fma(&b, &o, rows, states, step, steps);
    free(memory);
    return 0;
}
