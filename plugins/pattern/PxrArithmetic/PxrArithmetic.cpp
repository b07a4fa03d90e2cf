// PxrArithmetic: one operation on two colours, component by component. Division by 0 gives 0, powers are those of the
// absolute value with its sign, but where the power is even.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrArithmetic/PxrArithmetic.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kOperation, kInput1, kInput2 };
constexpr Param kParams[] = {
    param::integer("operation", 0)
        .range(0, 7)
        .options("0 add, 1 multiply, 2 subtract, 3 divide, 4 min, 5 max, 6 power, 7 modulo")
        .help("What is done; other numbers add. Powers of what is below 0 keep its sign, but for even ones."),
    param::color("input1", 0.f).help("First operand."),
    param::color("input2", 0.f).help("Second operand."),
    KINORA_COLOR_OUTPUTS,
};

struct PxrArithmetic {
  static constexpr uint32_t kComponents = 3;
  struct Setup {
    Value a, b;
    int operation;
    explicit Setup(const Context& c)
        : a(c.param(kInput1)), b(c.param(kInput2)), operation(fixedInteger(c, kOperation)) {}
    bool uniform() const { return allUniform({&a, &b}); }
  };
  template <int W>
  static KN_INLINE Float<W> one(int operation, Float<W> a, Float<W> b) {
    using F = Float<W>;
    const Mask<W> none = b == F(0.f);
    const F divisor = select(none, F(1.f), b);
    switch (operation) {
      case 1:
        return a * b;
      case 2:
        return a - b;
      case 3:
        return select(none, F(0.f), a / divisor);
      case 4:
        return min(a, b);
      case 5:
        return max(a, b);
      case 6: {
        // of what is below 0 the sign stays, but where the power is even
        const F half = b * F(0.5f), p = pow(abs(a), b);
        return select(none, F(1.f), select(a == F(0.f), F(0.f), select(half == floor(half), p, copySign(p, a))));
      }
      case 7:
        return select(none, F(0.f), fnma(floor(a / divisor), b, a));
      default:
        return a + b;
    }
  }
  template <int W>
  static KN_INLINE Rgb<W> at(const Setup& s, At at) {
    const Rgb<W> a = loadRgb<W>(s.a, at), b = loadRgb<W>(s.b, at);
    return {one(s.operation, a.x, b.x), one(s.operation, a.y, b.y), one(s.operation, a.z, b.z)};
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrArithmetic, .help = "Adds, multiplies ... two colours.", .params = kParams)
