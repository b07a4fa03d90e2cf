// Operands of kernels whose operands may each be uniform, and their results: plain values, or values with
// derivatives, behind one interface, so that an operation is written once for both. Included per target, after
// access.h.
#if defined(KINORA_LANGUAGE_OPERANDS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_OPERANDS_H_TARGET
#undef KINORA_LANGUAGE_OPERANDS_H_TARGET
#else
#define KINORA_LANGUAGE_OPERANDS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {

// ---- operands: plain {cell, step, varies}, dual {cell, step, dx, dy, derivStep, varies}; results {cell} or {cell,
// dx, dy}
template <int W>
struct PlainWords {
  using F = Float<W>;
  using V = Vec3<W>;
  static constexpr uint32_t kResult = 1, kOperand = 3;
  static constexpr int kWidth = W;
  static KN_INLINE F number(const Frame& f, const uint32_t* w, uint32_t i) {
    return fetch<W>(f.cells[w[0]], i, w[2]);
  }
  static KN_INLINE V triple(const Frame& f, const uint32_t* w, uint32_t i) {
    return {fetch<W>(f.cells[w[0]], i, w[2]), fetch<W>(f.cells[w[0] + w[1]], i, w[2]),
            fetch<W>(f.cells[w[0] + 2 * w[1]], i, w[2])};
  }
  static KN_INLINE void put(const Frame& f, const uint32_t* w, uint32_t i, F x, uint32_t c = 0) {
    x.store(f.cells[w[0] + c] + i);
  }
  static KN_INLINE void put(const Frame& f, const uint32_t* w, uint32_t i, V x) {
    x.x.store(f.cells[w[0]] + i);
    x.y.store(f.cells[w[0] + 1] + i);
    x.z.store(f.cells[w[0] + 2] + i);
  }
};
template <int W>
struct DualWords {
  using F = Dual<W>;
  using V = Dual3<W>;
  static constexpr uint32_t kResult = 3, kOperand = 6;
  static constexpr int kWidth = W;
  static KN_INLINE F number(const Frame& f, const uint32_t* w, uint32_t i, uint32_t c = 0) {
    return DualOperand(f, w, c).template get<W>(i, w[5]);
  }
  static KN_INLINE V triple(const Frame& f, const uint32_t* w, uint32_t i) {
    return {number(f, w, i, 0), number(f, w, i, 1), number(f, w, i, 2)};
  }
  static KN_INLINE void put(const Frame& f, const uint32_t* w, uint32_t i, F x, uint32_t c = 0) {
    DualCells(f, w, c).put(x, i);
  }
  static KN_INLINE void put(const Frame& f, const uint32_t* w, uint32_t i, V x) {
    put(f, w, i, x.x, 0);
    put(f, w, i, x.y, 1);
    put(f, w, i, x.z, 2);
  }
};

}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
