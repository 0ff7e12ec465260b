/* Interpreter of tapes (see nospill/compiled/tape.py), COLUMNS columns at once. Before it stand OPERATIONS, a case of its
   switch for each, and the codes INPUT, OUTPUT and CONSTANT (see libraries.py). */
#include <stdlib.h>
#include <string.h>
#define COLUMNS 16 /* as compiled/interpreter.py has it */
#define FOURS (COLUMNS / 4)
typedef union { four part[FOURS]; double of[COLUMNS]; } value;
typedef struct { int32_t operation, to, one, other; } instruction;

/* One function in every copy of this library. */
static long long count, inputs, outputs, registers, steps;
static instruction* code;
static double* constants;
static long long (*shapes)[3];
static int* shared; /* whether an input is the same for all columns */

static void* kept(const void* from, long long bytes) { return memcpy(malloc(bytes + 1), from, bytes); }

void set_tape(long long instructions, const void* of, const double* numbers, long long bytes, long long places,
              long long n_in, long long n_out, const long long* all_shapes, const int* which_shared, long long times) {
  count = instructions;
  code = kept(of, instructions * sizeof(instruction));
  constants = kept(numbers, bytes);
  registers = places;
  inputs = n_in;
  outputs = n_out;
  shapes = kept(all_shapes, (n_in + n_out) * sizeof(*shapes));
  shared = kept(which_shared, n_in * sizeof(*shared));
  steps = times;
}

long long tape_n_in(void) { return inputs; }
long long tape_n_out(void) { return outputs; }
const long long* tape_sparsity_in(long long i) { return 0 <= i && i < inputs ? shapes[i] : 0; }
const long long* tape_sparsity_out(long long i) { return 0 <= i && i < outputs ? shapes[inputs + i] : 0; }
int tape_work(long long* sz_arg, long long* sz_res, long long* sz_iw, long long* sz_w) {
  if (sz_arg) *sz_arg = inputs;
  if (sz_res) *sz_res = outputs;
  if (sz_iw) *sz_iw = 0;
  if (sz_w) *sz_w = (registers + 2 * shapes[0][0]) * COLUMNS + 8;
  return 0;
}

static void load(const double* from, long long input, long long row, long long step, value* to) {
  long long rows = shapes[input][0];
  if (!from) memset(to, 0, sizeof(value));
  else for (int j = 0; j < COLUMNS; ++j) to->of[j] = from[(shared[input] ? step : j) * rows + row];
}

#if defined(__x86_64__) && defined(__gnu_linux__)
__attribute__((target_clones("avx2", "default")))
#endif
static int run(const double** arg, double** res, long long step, value* places, const value* before, value* after) {
  for (long long i = 0; i < count; ++i) {
    const instruction at = code[i];
    if (at.operation == INPUT) {
      if (step && !at.one) places[at.to] = before[at.other];
      else load(arg[at.one], at.one, at.other, step, places + at.to);
      continue;
    }
    if (at.operation == OUTPUT) {
      double* to = res[at.to];
      long long rows = shapes[inputs + at.to][0], first = step * COLUMNS;
      if (to) for (int j = 0; j < COLUMNS; ++j) to[(first + j) * rows + at.other] = places[at.one].of[j];
      if (steps > 1 && !at.to) after[at.other] = places[at.one];
      continue;
    }
    value* to = places + at.to;
    if (at.operation == CONSTANT) {
      for (int j = 0; j < FOURS; ++j) to->part[j] = ALL(constants[at.one]);
      continue;
    }
    const value *one = places + at.one, *other = places + at.other;
    switch (at.operation) {
      OPERATIONS
      default: return 1;
    }
  }
  return 0;
}

/* Step after step; the state is kept twice, since a step may hand on the new one before it has read all of the old. */
int tape(const double** arg, double** res, long long* iw, double* w, int mem) {
  value *places = (value*)(((uintptr_t)w + 63) / 64 * 64), *states = places + registers;
  long long rows = shapes[0][0];
  for (long long step = 0; step < steps; ++step)
    if (run(arg, res, step, places, states + (step + 1) % 2 * rows, states + step % 2 * rows)) return 1;
  return 0;
}
