/* A set's vectors. No include guard. */
#undef vf
#undef vi
#undef vu
#undef vl
#define vf SET(floats)
#define vi SET(ints)
#define vu SET(words)
#define vl SET(longs) /* half as many lanes */
typedef float vf __attribute__((vector_size(4 * LANES)));
typedef int32_t vi __attribute__((vector_size(4 * LANES)));
typedef uint32_t vu __attribute__((vector_size(4 * LANES)));
typedef uint64_t vl __attribute__((vector_size(4 * LANES)));
