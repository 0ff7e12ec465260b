/* Functions that are compiled twice: with the fused products of vectors that most processors have, and without. What both
   call is inlined into either. */

#if !defined(WITHOUT_FMA) && defined(__x86_64__) && defined(__GNUC__)
#define WITH_FMA __attribute__((target("avx2,fma")))
#define HAS_FMA (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
#else
#define WITH_FMA
#define HAS_FMA 0
#endif

#define INLINE static inline __attribute__((always_inline))
