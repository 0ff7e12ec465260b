/* Waves of second order that known ones of the first drive, as potential_flow/driven_along.py has them: what drives them
   as quadratic forms of the modes that drive (interactions.py), then an oscillator for each mode that has no nodal
   diameter, or for a pair of cosine and sine, in axes that do not turn with the cup. */

typedef double loose __attribute__((vector_size(32), aligned(8))); /* four numbers at any address */

typedef struct {
    int modes, driving, oscillators, width; /* vectors in a row of both forms, a multiple of 4 */
    const int *own, *other;                 /* by oscillators: its mode, and the sine's or -1 */
    const double *stiffness, *damping, *turn; /* by modes that drive: kappa, pressures per rate and per turn */
    const double *place, *rise, *lean, *slip; /* by them and axes */
    const double *spin;                       /* by them twice */
    const double *kappa, *friction, *diameters; /* by oscillators */
    const double *surface, *pressure;           /* rows of the forms, by products */
} Liquid;

typedef struct {
    double *velocity, *change, *pairs, *products;
    double *source, *push;         /* by modes */
    double *pushed, *state;        /* by oscillators: height, own velocity, cosine and sine of each */
    double *fade;                  /* by oscillators: what damping leaves of a step */
} Workplace;

/* Sums of rows, each times its number: even and odd ones apart, so that no sum waits for the one before. */
INLINE void combined(int width, int count, const double *numbers, const double *rows, double *sums) {
    for (int v = 0; v < width; v += 4) {
        four sum[2][4] = {{{0.0}}};
        const loose *row = (const loose *)rows + v;
        for (int p = 0; p + 1 < count; p += 2, row += 2 * width)
            for (int a = 0; a < 4; a++) sum[0][a] += numbers[p] * row[a], sum[1][a] += numbers[p + 1] * row[width + a];
        for (int a = 0; count & 1 && a < 4; a++) sum[0][a] += numbers[count - 1] * row[a];
        for (int a = 0; a < 4; a++) ((loose *)sums)[v + a] = sum[0][a] + sum[1][a];
    }
}

/* What heights and their rates drive at an instant: rates of the surface, and pressures over density. */
INLINE void drive(const Liquid *b, const Workplace *o, const double *row, const double *height, const double *rate) {
    const int n = b->driving;
    const double lean[2] = {row[1], -row[0]}, lean_rate[2] = {row[4], -row[3]}, *force = row + 6;
    double *velocity = o->velocity, *change = o->change;
    for (int i = 0; i < n; i++) { /* rates are those of both the potentials, the lean and the turn */
        double carried = 0.0;
        for (int j = 0; j < n; j++) carried += b->spin[i * n + j] * height[j];
        const double leaned = b->rise[2 * i] * lean[0] + b->rise[2 * i + 1] * lean[1];
        velocity[i] = (rate[i] + row[2] * carried - leaned) / b->stiffness[i];
    }
    for (int i = 0; i < n; i++) {
        const double *place = b->place + 2 * i, *leaning = b->lean + 2 * i, *slip = b->slip + 2 * i;
        double spun = slip[0] * lean[0] + slip[1] * lean[1];
        for (int j = 0; j < n; j++) spun += b->spin[i * n + j] * velocity[j];
        change[i] = -(force[2] * height[i] + place[0] * force[0] + place[1] * force[1] + leaning[0] * lean_rate[0] +
                      leaning[1] * lean_rate[1] + b->turn[i] * row[5] + row[2] * spun + b->damping[i] * rate[i]);
    }
    for (int a = 0; a < 2; a++) velocity[n + a] = lean[a], change[n + a] = lean_rate[a];
    for (int i = 0; i < n + 2; i++) change[n + 2 + i] = row[2] * velocity[i];
    double *pair = o->pairs, *product = o->products;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n + 2; j++) *pair++ = height[i] * velocity[j];
        for (int j = 0; j < 2 * n + 4; j++) *product++ = height[i] * change[j];
    }
    for (int i = 0; i < n + 2; i++)
        for (int j = i; j < n + 2; j++) *product++ = velocity[i] * velocity[j];
    *product++ = row[2] * row[2];
    combined(b->width, (int)(pair - o->pairs), o->pairs, b->surface, o->source);
    combined(b->width, (int)(product - o->products), o->products, b->pressure, o->push);
}

/* A step of one oscillator, cosine and sine, h in s under this force, fade = exp(-decay h): what was pushed at its
   beginning enters at half, as what is pushed at its end. */
INLINE void step_on(double kappa, double decay, double fade, double force, double h, const double *before,
                    const double *after, double *state) {
    const double square = kappa * force - decay * decay, root = sqrt(fabs(square));
    double cosine = fade, sine = fade * h; /* of a mode that stands still */
    if (root >= 1e-9 && square > 0.0)
        cosine = fade * cos(root * h), sine = fade * sin(root * h) / root;
    else if (root >= 1e-9)
        cosine = fade * cosh(root * h), sine = fade * sinh(root * h) / root;
    for (int a = 0; a < 2; a++) {
        const double height = state[a] + h / 2.0 * before[a], velocity = state[2 + a] + h / 2.0 * before[2 + a];
        state[a] = (cosine + decay * sine) * height + kappa * sine * velocity + h / 2.0 * after[a];
        state[2 + a] = (cosine - decay * sine) * velocity - force * sine * height + h / 2.0 * after[2 + a];
    }
}

/* Two numbers of a pair, turned. */
INLINE void turned(double cosine, double sine, const double *pair, double *to) {
    const double x = pair[0], y = pair[1];
    to[0] = cosine * x - sine * y, to[1] = sine * x + cosine * y;
}

/* One motion, of `count` instants. */
INLINE void along(const Liquid *b, const Workplace *o, int count, const double *rows, const double *heights,
                  const double *rates, const double *steps, const double *begin, double *states) {
    double angle = 0.0;
    for (int k = 0; k < count; k++, rows += ROW, heights += b->driving, rates += b->driving, states += 2 * b->modes) {
        const double h = k ? steps[k - 1] : 0.0, force = k ? (rows[8] + rows[8 - ROW]) / 2.0 : 0.0;
        if (k) angle += (rows[2] + rows[2 - ROW]) / 2.0 * h;
        drive(b, o, rows, heights, rates);
        double turn = 0.0, cosine = 1.0, sine = 0.0;
        for (int l = 0; l < b->oscillators; l++) {
            const int own = b->own[l], other = b->other[l];
            const double kappa = b->kappa[l], friction = b->friction[l], decay = friction * kappa / 2.0;
            if (b->diameters[l] * angle != turn)
                turn = b->diameters[l] * angle, cosine = cos(turn), sine = sin(turn);
            if (k == 1 || (k && h != steps[k - 2])) o->fade[l] = exp(-decay * h);
            double *before = o->pushed + 4 * l, *state = o->state + 4 * l, after[4] = {0.0}, shown[4];
            after[0] = o->source[own], after[2] = -o->push[own] - friction * o->source[own];
            if (other >= 0) after[1] = o->source[other], after[3] = -o->push[other] - friction * o->source[other];
            for (int a = 0; a < 4; a += 2) turned(cosine, sine, after + a, after + a);
            if (k)
                step_on(kappa, decay, o->fade[l], force, h, before, after, state);
            else
                for (int a = 0; a < 2; a++) {
                    const double *own_begin = begin + a * b->modes, scale = a ? kappa : 1.0;
                    state[2 * a] = own_begin[own] / scale;
                    state[2 * a + 1] = other < 0 ? 0.0 : own_begin[other] / scale;
                }
            for (int a = 0; a < 4; a++) before[a] = after[a];
            for (int a = 0; a < 4; a += 2) turned(cosine, -sine, state + a, shown + a);
            states[own] = shown[0], states[b->modes + own] = kappa * shown[2];
            if (other >= 0) states[other] = shown[1], states[b->modes + other] = kappa * shown[3];
        }
    }
}

#define ALL_OF_THEM                                                                                                    \
    for (int a = 0; a < motions; a++) {                                                                                \
        const int first = a * count;                                                                                   \
        along(b, o, count, rows + first * ROW, heights + first * b->driving, rates + first * b->driving, steps, begin, \
              states + first * 2 * b->modes);                                                                          \
    }

#define GIVEN                                                                                                          \
    const Liquid *b, const Workplace *o, int motions, int count, const double *rows, const double *heights,            \
        const double *rates, const double *steps, const double *begin, double *states

WITH_FMA static void driven_with_fma(GIVEN) { ALL_OF_THEM }

static void driven_without_fma(GIVEN) { ALL_OF_THEM }

/* Heights and own velocities (motions, count, 2, modes), zeros before, of some motions that begin alike and take the
   same steps, in s.

   counts: modes, driving, oscillators, width, then own and other. tables: those of Liquid, one after the other. rows
   (motions, count, 9), heights and rates (motions, count, driving), steps (count - 1), begin (2, modes). 0, or 1 where
   memory is short. */
int driven_waves(const int *counts, const double *tables, const double *rows, const double *heights,
                 const double *rates, const double *steps, const double *begin, double *states, int motions,
                 int count) {
    const int n = counts[1], l = counts[2], width = counts[3];
    Liquid b = {.modes = counts[0], .driving = n, .oscillators = l, .width = width};
    b.own = counts + 4, b.other = b.own + l;
    b.stiffness = table(&tables, n), b.damping = table(&tables, n), b.turn = table(&tables, n);
    b.place = table(&tables, 2 * n), b.rise = table(&tables, 2 * n), b.lean = table(&tables, 2 * n);
    b.slip = table(&tables, 2 * n), b.spin = table(&tables, n * n);
    b.kappa = table(&tables, l), b.friction = table(&tables, l), b.diameters = table(&tables, l);
    b.surface = table(&tables, 4 * width * n * (n + 2)), b.pressure = tables;

    const int products = n * (2 * n + 4) + (n + 2) * (n + 3) / 2 + 1;
    double *room = malloc((3 * n + 6 + n * (n + 2) + products + 8 * width + 9 * l) * sizeof(double));
    if (!room) return 1;
    Workplace o = {.velocity = room, .change = room + n + 2, .pairs = room + 3 * n + 6};
    o.products = o.pairs + n * (n + 2), o.source = o.products + products, o.push = o.source + 4 * width;
    o.pushed = o.push + 4 * width, o.state = o.pushed + 4 * l, o.fade = o.state + 4 * l;
    if (HAS_FMA)
        driven_with_fma(&b, &o, motions, count, rows, heights, rates, steps, begin, states);
    else
        driven_without_fma(&b, &o, motions, count, rows, heights, rates, steps, begin, states);
    free(room);
    return 0;
}
