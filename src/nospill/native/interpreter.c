/* Interpreter of tapes (see nospill/compiled/tape.py), COLUMNS columns at once. Before it stand OPERATIONS, a case of its
   switch for each, and the codes INPUT, OUTPUT and CONSTANT (see libraries.py). */
#include <stdlib.h>
#include <string.h>
#define COLUMNS 16 /* as compiled/interpreter.py has it */
#define FOURS (COLUMNS / 4)
typedef union { four part[FOURS]; double of[COLUMNS]; } value;
typedef struct { int32_t operation, to, one, other; } instruction;

/* One function in every copy of this library. */
static long long count, inputs, outputs, registers;
static instruction* code;
static double* constants;
static long long (*shapes)[3];

static void* kept(const void* from, long long bytes) { return memcpy(malloc(bytes + 1), from, bytes); }

void set_tape(long long instructions, const void* of, const double* numbers, long long bytes, long long places,
              long long n_in, long long n_out, const long long* all_shapes) {
  count = instructions;
  code = kept(of, instructions * sizeof(instruction));
  constants = kept(numbers, bytes);
  registers = places;
  inputs = n_in;
  outputs = n_out;
  shapes = kept(all_shapes, (n_in + n_out) * sizeof(*shapes));
}

long long tape_n_in(void) { return inputs; }
long long tape_n_out(void) { return outputs; }
const long long* tape_sparsity_in(long long i) { return 0 <= i && i < inputs ? shapes[i] : 0; }
const long long* tape_sparsity_out(long long i) { return 0 <= i && i < outputs ? shapes[inputs + i] : 0; }
int tape_work(long long* sz_arg, long long* sz_res, long long* sz_iw, long long* sz_w) {
  if (sz_arg) *sz_arg = inputs;
  if (sz_res) *sz_res = outputs;
  if (sz_iw) *sz_iw = 0;
  if (sz_w) *sz_w = registers * COLUMNS + 8;
  return 0;
}

static void load(const double* from, const long long* shape, long long row, value* to) {
  if (!from) memset(to, 0, sizeof(value));
  else for (int j = 0; j < COLUMNS; ++j) to->of[j] = from[shape[1] == 1 ? row : j * shape[0] + row];
}

#if defined(__x86_64__) && defined(__gnu_linux__)
__attribute__((target_clones("avx2", "default")))
#endif
int tape(const double** arg, double** res, long long* iw, double* w, int mem) {
  value* places = (value*)(((uintptr_t)w + 63) / 64 * 64);
  for (long long i = 0; i < count; ++i) {
    const instruction at = code[i];
    if (at.operation == INPUT) {
      load(arg[at.one], shapes[at.one], at.other, places + at.to);
      continue;
    }
    if (at.operation == OUTPUT) {
      double* to = res[at.to];
      if (to) for (int j = 0; j < COLUMNS; ++j) to[j * shapes[inputs + at.to][0] + at.other] = places[at.one].of[j];
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
