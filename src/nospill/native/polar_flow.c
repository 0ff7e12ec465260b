/* The nonlinear flow of four cups as potential_flow/nonlinear.py has it, in polar coordinates: every mode is a radial
   function R times cos or sin(m theta), points lie on rings with spokes in common. A wave has one such mode without
   nodal diameters (m = 0) and two with them. Lengths are over one of each cup, in which all discs are the same; depths
   and dampings are not.

   An exponential is taken for every point and wave, not for every mode, and integrals of F_m Q_j are Fourier sums over
   the spokes of each ring, then sums over rings. The bottom's part of a lean has the form of what comes back from the
   bottom, exp(-k z), and is added to that. */

typedef struct {
    int rings, spokes, waves, modes;
    int orders;                                   /* of Fourier sums, from 0 on; a multiple of BLOCK */
    const double *diameters, *wave_number;        /* by waves: m, k */
    const double *place;                          /* by waves: share in the function x, and of its other mode in y */
    const double *radial, *outward;               /* by waves and rings: R and its slope */
    const double *radius, *weight;                /* by rings: that, and the area of a point */
    const double *cosine, *sine;                  /* by orders and spokes: of order times angle */
    const four *fall;                             /* by waves: exp(-k h) */
    const four *damping;                          /* by modes: of the pressure per rate, times the norm */
    const four *step;                             /* s */
    double greatest;                              /* height from which on there is no flow */
} Basin;

typedef struct {
    four *height, *steep, *across, *velocity, *sideways, *rise, *lift; /* by rings and spokes */
    four *value;                                                       /* by waves, rings and spokes */
    four *along, *turned, *back, *back_turned, *leaned;                /* by spokes */
    four *even, *odd, *cosines, *sines;                                /* by rings and half the spokes, or orders */
    four *matrix, *inverse, *stages;
    double *half_cosine, *half_sine;                                   /* by half the spokes and orders */
} Room;

/* Amplitudes of a wave's modes -> its values along the spokes, and their derivative by the angle. */
INLINE void around(const Basin *b, int m, four cosine, four sine, four *values, four *derivative) {
    const double *c = b->cosine + m * b->spokes, *d = b->sine + m * b->spokes;
    for (int s = 0; s < b->spokes; s++) {
        values[s] = cosine * c[s] + sine * d[s];
        derivative[s] = (sine * c[s] - cosine * d[s]) * (double)m;
    }
}

/* Heights and slopes, radial and along the circle, of the surface. */
INLINE void surface(const Basin *b, const Room *o, const four *state) {
    const int points = b->rings * b->spokes;
    for (int p = 0; p < points; p++) o->height[p] = o->steep[p] = o->across[p] = (four){0.0};
    for (int q = 0, j = 0; q < b->waves; q++) {
        const int m = (int)b->diameters[q];
        around(b, m, state[j], m ? state[j + 1] : (four){0.0}, o->along, o->turned);
        j += m ? 2 : 1;
        for (int g = 0, p = 0; g < b->rings; g++) {
            const double radial = b->radial[q * b->rings + g], outward = b->outward[q * b->rings + g];
            const double by_radius = radial / b->radius[g];
            for (int s = 0; s < b->spokes; s++, p++) {
                o->height[p] += radial * o->along[s];
                o->steep[p] += outward * o->along[s];
                o->across[p] += by_radius * o->turned[s];
            }
        }
    }
    for (int p = 0; p < points; p++) { /* not a number where there is no flow */
        mask high = (mask)(o->height[p] > b->greatest) | (mask)(o->height[p] < -b->greatest);
        o->height[p] = (four)((mask)o->height[p] | high);
    }
}

/* Velocities of a wave at the surface, and its values there per amplitude. */
INLINE void add_wave(const Basin *b, const Room *o, int q, int leans) {
    const double k = b->wave_number[q], doubles = k * 1.4426950408889634;
    const four bottom = b->fall[q] * b->fall[q], share = 1.0 / (1.0 + bottom);
    four *value = o->value + q * b->rings * b->spokes;
    for (int g = 0, p = 0; g < b->rings; g++) {
        const double radial = b->radial[q * b->rings + g], outward = b->outward[q * b->rings + g];
        const double by_radius = radial / b->radius[g], rising = radial * k;
        const four scale = radial * share;
        for (int s = 0; s < b->spokes; s++, p++) {
            four up, down;
            powers_of_two(o->height[p] * doubles, &up, &down); /* exp(k eta), exp(-k eta) */
            const four one = up * o->along[s], other = down * o->back[s];
            o->velocity[p] += outward * (one + other);
            o->rise[p] += rising * (one - other);
            o->sideways[p] += by_radius * (up * o->turned[s] + down * o->back_turned[s]);
            value[p] = scale * (up + bottom * down);
            if (leans) o->lift[p] += radial * down * o->leaned[s];
        }
    }
}

/* Velocities, of the flow and of what turns of the container excite, values of all waves, and what leans push with. */
INLINE void fields(const Basin *b, const Room *o, const four *potential, const four *row) {
    const four lean[2] = {row[1], -row[0]}, lean_rate[2] = {row[4], -row[3]};
    const double *c = b->cosine + b->spokes, *d = b->sine + b->spokes;
    for (int g = 0, p = 0; g < b->rings; g++)
        for (int s = 0; s < b->spokes; s++, p++) {
            const double x = b->radius[g] * c[s], y = b->radius[g] * d[s];
            o->velocity[p] = (four){0.0};
            o->sideways[p] = -b->radius[g] * row[2];
            o->rise[p] = 2.0 * (x * lean[0] + y * lean[1]);
            o->lift[p] = (x * lean_rate[0] + y * lean_rate[1]) * o->height[p];
        }
    for (int q = 0, j = 0; q < b->waves; q++) {
        const int m = (int)b->diameters[q];
        const four fall = b->fall[q], share = 1.0 / (1.0 + fall * fall);
        const four leaning = fall * (2.0 * b->place[q] / b->wave_number[q]);
        four own[2] = {share * potential[j], m ? share * potential[j + 1] : (four){0.0}}, back[2];
        for (int a = 0; a < 2; a++) back[a] = fall * fall * own[a] + leaning * lean[a];
        j += m ? 2 : 1;
        around(b, m, leaning * lean_rate[0], leaning * lean_rate[1], o->leaned, o->turned);
        around(b, m, own[0], own[1], o->along, o->turned);
        around(b, m, back[0], back[1], o->back, o->back_turned);
        if (b->place[q] != 0.0)
            add_wave(b, o, q, 1);
        else
            add_wave(b, o, q, 0);
    }
}

/* What goes through the surface, in place of the rise, and the pressure over density there, in place of the lift. */
INLINE void conditions(const Basin *b, const Room *o, const four *row) {
    const four *omega = row, *force = row + 6;
    const double *c = b->cosine + b->spokes, *d = b->sine + b->spokes;
    for (int g = 0, p = 0; g < b->rings; g++)
        for (int s = 0; s < b->spokes; s++, p++) {
            const double x = b->radius[g] * c[s], y = b->radius[g] * d[s];
            const four height = o->height[p], rise = o->rise[p], out = o->velocity[p], side = o->sideways[p];
            const four wall[3] = {omega[1] * height - omega[2] * y, omega[2] * x - omega[0] * height,
                                  omega[0] * y - omega[1] * x};
            four squares = out * out + side * side + rise * rise;
            for (int a = 0; a < 3; a++) squares -= wall[a] * wall[a];
            o->lift[p] += force[0] * x + force[1] * y + force[2] * height + 0.5 * squares;
            o->rise[p] = rise - o->steep[p] * out - o->across[p] * side;
        }
}

/* Fourier sums (rings, orders) of values (rings, spokes). */
INLINE void summed(const Basin *b, const Room *o, const four *values) {
    fourier(b->rings, b->spokes, b->orders, o->half_cosine, o->half_sine, values, o->even, o->odd, o->cosines, o->sines);
}

/* Where the sums of an order are: at angles (s + 1/2) 2 pi/n those of n - l are the same, cosines with another sign. */
INLINE int place_of(const Basin *b, int order) { return 2 * order > b->spokes ? b->spokes - order : order; }

INLINE double sign_of(const Basin *b, int order) { return 2 * order > b->spokes ? -1.0 : 1.0; }

/* Integrals of all modes times the values of a wave's modes: two columns of the matrix from column j on, or one. */
INLINE void couple(const Basin *b, const Room *o, int q, int j) {
    const int m = (int)b->diameters[q];
    summed(b, o, o->value + q * b->rings * b->spokes);
    for (int r = 0, i = 0; r < b->waves; r++) {
        const int own = (int)b->diameters[r], apart = abs(own - m), together = own + m;
        const int at[2] = {place_of(b, apart), place_of(b, together)};
        four even[2] = {{0.0}, {0.0}}, odd[2] = {{0.0}, {0.0}};
        for (int g = 0; g < b->rings; g++) {
            const double weight = 0.5 * b->weight[g] * b->radial[r * b->rings + g];
            for (int a = 0; a < 2; a++) {
                even[a] += weight * o->cosines[g * b->orders + at[a]];
                odd[a] += weight * o->sines[g * b->orders + at[a]];
            }
        }
        even[0] *= sign_of(b, apart);
        even[1] *= sign_of(b, together);
        if (own > m) odd[0] = -odd[0]; /* sines of the order m - own */
        four *row = o->matrix + i * b->modes + j;
        row[0] = even[0] + even[1];
        if (m) row[1] = odd[1] + odd[0];
        if (own) row[b->modes] = odd[1] - odd[0];
        if (own && m) row[b->modes + 1] = even[0] - even[1];
        i += own ? 2 : 1;
    }
}

/* Integrals of a wave's modes' values times what goes through the surface. */
INLINE void carry(const Basin *b, const Room *o, int q, four *carried) {
    const int m = (int)b->diameters[q];
    const double *c = b->cosine + m * b->spokes, *d = b->sine + m * b->spokes;
    const four *value = o->value + q * b->rings * b->spokes;
    four sums[2] = {{0.0}, {0.0}};
    for (int s = 0; s < b->spokes; s++) {
        four along = {0.0};
        for (int g = 0; g < b->rings; g++)
            along += b->weight[g] * o->rise[g * b->spokes + s] * value[g * b->spokes + s];
        sums[0] += along * c[s];
        sums[1] += along * d[s];
    }
    carried[0] = sums[0];
    if (m) carried[1] = sums[1];
}

/* Rates of a state, heights and potentials of all modes, along a row of the motion. */
INLINE void rate_of(const Basin *b, const Room *o, const four *state, const four *row, four *rate) {
    const int n = b->modes;
    surface(b, o, state);
    fields(b, o, state + n, row);
    conditions(b, o, row);
    for (int q = 0, j = 0; q < b->waves; j += b->diameters[q] ? 2 : 1, q++) {
        couple(b, o, q, j);
        carry(b, o, q, rate + j);
    }
    factorise(n, o->matrix, o->inverse);
    solve_transposed(n, o->matrix, o->inverse, rate);
    summed(b, o, o->lift);
    for (int q = 0, j = 0; q < b->waves; q++) {
        const int m = (int)b->diameters[q];
        four push[2] = {{0.0}, {0.0}};
        for (int g = 0; g < b->rings; g++) {
            const double weight = b->weight[g] * b->radial[q * b->rings + g];
            push[0] -= weight * o->cosines[g * b->orders + m];
            push[1] -= weight * o->sines[g * b->orders + m];
        }
        for (int a = 0; a < (m ? 2 : 1); a++, j++) rate[n + j] = push[a] - b->damping[j] * rate[j];
    }
    solve(n, o->matrix, o->inverse, rate + n);
}
