/* Runge-Kutta steps of the flow of polar_flow.c, and what is called from outside. */

INLINE void runge_kutta(const Basin *b, const Room *o, const four *rows, four *states, int steps) {
    static const double reach[3] = {0.5, 0.5, 1.0}, share[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    const int n = 2 * b->modes;
    const four step = *b->step;
    four *rate = o->stages, *there = o->stages + n;
    for (int k = 0; k < steps; k++, rows += 2 * ROW, states += n) {
        four *next = states + n;
        for (int j = 0; j < n; j++) next[j] = there[j] = states[j];
        for (int a = 0; a < 4; a++) {
            rate_of(b, o, there, rows + (a + 1) / 2 * ROW, rate);
            for (int j = 0; j < n; j++) next[j] += step * share[a] * rate[j];
            for (int j = 0; a < 3 && j < n; j++) there[j] = states[j] + step * reach[a] * rate[j];
        }
    }
}

WITH_FMA static void steps_with_fma(const Basin *b, const Room *o, const four *rows, four *states, int steps) {
    runge_kutta(b, o, rows, states, steps);
}

static void steps_without_fma(const Basin *b, const Room *o, const four *rows, four *states, int steps) {
    runge_kutta(b, o, rows, states, steps);
}

/* The next `count` numbers of what is left, in whole vectors. */
static four *part(four **left, int count) {
    four *own = *left;
    *left += count;
    return own;
}

static const double *table(const double **left, int count) {
    const double *own = *left;
    *left += count;
    return own;
}

/* States (steps + 1, 2 modes, 4) of four cups, of which the first is given.

   counts: rings, spokes, waves, modes, orders. tables: those of Basin, one after the other, greatest last but
   for those of each cup, own (waves + modes + 1, 4). rows (2 steps + 1, 9, 4) at the ends and middles of the steps. All of
   them are aligned to 32 bytes but the tables. 0, or 1 where memory is short. */
int flow_steps(const int *counts, const double *tables, const double *own, const double *rows, double *states,
               int steps) {
    Basin b = {.rings = counts[0], .spokes = counts[1], .waves = counts[2], .modes = counts[3], .orders = counts[4]};
    const int points = b.rings * b.spokes, half = (b.spokes + 1) / 2, sums = half * b.orders;
    b.diameters = table(&tables, b.waves), b.wave_number = table(&tables, b.waves);
    b.place = table(&tables, b.waves);
    b.radial = table(&tables, b.waves * b.rings), b.outward = table(&tables, b.waves * b.rings);
    b.radius = table(&tables, b.rings), b.weight = table(&tables, b.rings);
    b.cosine = table(&tables, b.orders * b.spokes), b.sine = table(&tables, b.orders * b.spokes);
    b.greatest = *tables;
    b.fall = (const four *)own, b.damping = b.fall + b.waves, b.step = b.damping + b.modes;

    const int vectors = (7 + b.waves) * points + 5 * b.spokes + 2 * b.rings * (half + b.orders) +
                        b.modes * (b.modes + 5) + sums;
    void *memory = malloc((vectors + 1) * sizeof(four));
    if (!memory) return 1;
    four *left = (four *)(((uintptr_t)memory + sizeof(four) - 1) / sizeof(four) * sizeof(four));
    Room o = {.height = part(&left, points), .steep = part(&left, points), .across = part(&left, points)};
    o.velocity = part(&left, points), o.sideways = part(&left, points);
    o.rise = part(&left, points), o.lift = part(&left, points), o.value = part(&left, b.waves * points);
    o.along = part(&left, b.spokes), o.turned = part(&left, b.spokes), o.leaned = part(&left, b.spokes);
    o.back = part(&left, b.spokes), o.back_turned = part(&left, b.spokes);
    o.even = part(&left, b.rings * half), o.odd = part(&left, b.rings * half);
    o.cosines = part(&left, b.rings * b.orders), o.sines = part(&left, b.rings * b.orders);
    o.matrix = part(&left, b.modes * b.modes), o.inverse = part(&left, b.modes), o.stages = part(&left, 4 * b.modes);
    o.half_cosine = (double *)left, o.half_sine = o.half_cosine + sums; /* half of what is left for them */
    for (int s = 0; s < half; s++)
        for (int l = 0; l < b.orders; l++) {
            o.half_cosine[s * b.orders + l] = b.cosine[l * b.spokes + s];
            o.half_sine[s * b.orders + l] = b.sine[l * b.spokes + s];
        }
    if (HAS_FMA)
        steps_with_fma(&b, &o, (const four *)rows, (four *)states, steps);
    else
        steps_without_fma(&b, &o, (const four *)rows, (four *)states, steps);
    free(memory);
    return 0;
}
