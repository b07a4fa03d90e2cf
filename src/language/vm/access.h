// How kernels read and write cells: a vector of W points of a varying value, or one number for all of them.
// Included per target, after language/library/dual.h.
#if defined(KINORA_LANGUAGE_ACCESS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_ACCESS_H_TARGET
#undef KINORA_LANGUAGE_ACCESS_H_TARGET
#else
#define KINORA_LANGUAGE_ACCESS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {
using kinora::language::Frame;

template <bool kUniform, int W>
KN_INLINE Float<W> fetch(const float* p, uint32_t i) {
  if constexpr (kUniform)
    return Float<W>(p[0]);
  else
    return Float<W>::load(p + i);
}
template <int W>
KN_INLINE Float<W> fetch(const float* p, uint32_t i, bool varies) {
  return varies ? Float<W>::load(p + i) : Float<W>(p[0]);
}
template <int W>
KN_INLINE Int<W> fetchInt(const float* p, uint32_t i, bool varies) {
  return asInt(fetch<W>(p, i, varies));
}
template <int W>
KN_INLINE void put(Int<W> x, float* p, uint32_t i) {
  asFloat(x).store(p + i);
}
// An answer as an int: 1 or 0.
template <int W>
KN_INLINE void putAnswer(Mask<W> m, float* p, uint32_t i) {
  put(choose(m, Int<W>(1), Int<W>(0)), p, i);
}

// A mask is a cell of -1 for points that take part and 0 for the others.
template <int W>
KN_INLINE Mask<W> loadMask(const float* p, uint32_t i) {
  return asInt(Float<W>::load(p + i)) < Int<W>(0);
}
template <int W>
KN_INLINE void storeMask(Mask<W> m, float* p, uint32_t i) {
  put(choose(m, Int<W>(-1), Int<W>(0)), p, i);
}
// Which chunks hold points of a mask, as the bits of an int.
KN_INLINE void setChunks(float* cell, uint32_t chunks) { __builtin_memcpy(cell, &chunks, 4); }
template <int W>
KN_INLINE uint32_t chunkOf(Mask<W> m, uint32_t i) {
  return m.any() ? 1u << (i / 16) : 0u;
}

// The words of a result with derivatives and of its operands, one component at a time.
struct DualCells {
  float *v, *dx, *dy;
  KN_INLINE DualCells(const Frame& f, const uint32_t* w, uint32_t c)
      : v(f.cells[w[0] + c]), dx(f.cells[w[1] + c]), dy(f.cells[w[2] + c]) {}
  template <int W>
  KN_INLINE void put(const Dual<W>& x, uint32_t i) const {
    x.v.store(v + i);
    x.dx.store(dx + i);
    x.dy.store(dy + i);
  }
};
struct DualOperand {
  const float *v, *dx, *dy;
  KN_INLINE DualOperand(const Frame& f, const uint32_t* w, uint32_t c)
      : v(f.cells[w[0] + c * w[1]]), dx(f.cells[w[2] + c * w[4]]), dy(f.cells[w[3] + c * w[4]]) {}
  template <int W>
  KN_INLINE Dual<W> get(uint32_t i) const {
    return {Float<W>::load(v + i), Float<W>::load(dx + i), Float<W>::load(dy + i)};
  }
  template <int W>
  KN_INLINE Dual<W> get(uint32_t i, bool varies) const {
    return varies ? get<W>(i) : Dual<W>(Float<W>(v[0]));
  }
};

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
