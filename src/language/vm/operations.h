// What cheap operations of two numbers and comparisons do to the lanes of a vector: shared by the kernels that do one
// and those that do two. Included per target, after access.h.
#if defined(KINORA_LANGUAGE_OPERATIONS_H_TARGET) == defined(HWY_TARGET_TOGGLE)
#ifdef KINORA_LANGUAGE_OPERATIONS_H_TARGET
#undef KINORA_LANGUAGE_OPERATIONS_H_TARGET
#else
#define KINORA_LANGUAGE_OPERATIONS_H_TARGET
#endif

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace lang {
namespace operations {

struct Add {
  template <class A, class B>
  static KN_INLINE auto of(A a, B b) {
    return a + b;
  }
};
struct Sub {
  template <class A, class B>
  static KN_INLINE auto of(A a, B b) {
    return a - b;
  }
};
struct Mul {
  template <class A, class B>
  static KN_INLINE auto of(A a, B b) {
    return a * b;
  }
};
struct Div {
  template <class A, class B>
  static KN_INLINE auto of(A a, B b) {
    return lang::divide(a, b);
  }
  template <int W>
  static KN_INLINE Dual<W> of(Float<W> a, Dual<W> b) {
    return lang::divide(Dual<W>(a), b);
  }
};
// by a divisor that is known not to be 0
struct DivPlain {
  template <int W>
  static KN_INLINE Float<W> of(Float<W> a, Float<W> b) {
    return a / b;
  }
  template <class A, class B>
  static KN_INLINE auto of(A a, B b) {
    return Div::of(a, b);
  }
  template <int W>
  static KN_INLINE Dual<W> of(Dual<W> a, Float<W> b) {
    const Float<W> inverse = Float<W>(1.f) / b;
    return {a.v / b, inverse * a.dx, inverse * a.dy};
  }
};
#define KN_EXTREME(Name, function)                       \
  struct Name {                                          \
    template <class A>                                   \
    static KN_INLINE A of(A a, A b) {                    \
      return lang::function(a, b);                       \
    }                                                    \
    template <int W>                                     \
    static KN_INLINE Dual<W> of(Dual<W> a, Float<W> b) { \
      return lang::function(a, Dual<W>(b));              \
    }                                                    \
    template <int W>                                     \
    static KN_INLINE Dual<W> of(Float<W> a, Dual<W> b) { \
      return lang::function(Dual<W>(a), b);              \
    }                                                    \
  };
KN_EXTREME(Min, least)
KN_EXTREME(Max, greatest)
#undef KN_EXTREME

// Comparisons of numbers, and of ints given by their bits.
#define KN_COMPARE(Name, test)                              \
  struct Name##F {                                          \
    template <int W>                                        \
    static KN_INLINE Mask<W> of(Float<W> a, Float<W> b) {   \
      return test;                                          \
    }                                                       \
  };                                                        \
  struct Name##I {                                          \
    template <int W>                                        \
    static KN_INLINE Mask<W> of(Float<W> fa, Float<W> fb) { \
      const Int<W> a = asInt(fa), b = asInt(fb);            \
      return test;                                          \
    }                                                       \
  };
KN_COMPARE(Eq, a == b)
KN_COMPARE(Neq, a != b)
KN_COMPARE(Lt, a < b)
KN_COMPARE(Le, b >= a)
KN_COMPARE(Gt, a > b)
KN_COMPARE(Ge, a >= b)
#undef KN_COMPARE

}  // namespace operations
}  // namespace lang
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();
#endif
