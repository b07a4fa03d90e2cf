// PxrSwitch: one of a list of colours by number; numbers are rounded and go round.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrSwitch/PxrSwitch.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

// Elements of the list that patterns feed are parameters of their own: inputsRGB_0 ... They may be said one by one, with
// gaps, and beyond the end of the list, which then is as long as they reach.
enum : uint32_t { kIndex, kInputsRGB, kElement0 };
constexpr uint32_t kMost = 16;
#define KINORA_INPUT(n) \
  structural(param::color("inputsRGB_" #n, -1.f)).help("Element " #n " where something is connected to it.")
constexpr Param kParams[] = {
    param::number("index", 0.f)
        .range(0, 15)
        .help("Number of the colour, from 0, rounded; past the last it goes round."),
    param::array(Type::Color, "inputsRGB", nullptr, 0)
        .help("The colours; \"reference color[n]\" connects n of them (\"\": not that one), \"reference color "
              "inputsRGB[k]\" one. Those that nothing says are black."),
    KINORA_INPUT(0),
    KINORA_INPUT(1),
    KINORA_INPUT(2),
    KINORA_INPUT(3),
    KINORA_INPUT(4),
    KINORA_INPUT(5),
    KINORA_INPUT(6),
    KINORA_INPUT(7),
    KINORA_INPUT(8),
    KINORA_INPUT(9),
    KINORA_INPUT(10),
    KINORA_INPUT(11),
    KINORA_INPUT(12),
    KINORA_INPUT(13),
    KINORA_INPUT(14),
    KINORA_INPUT(15),
    KINORA_COLOR_OUTPUTS,
};
#undef KINORA_INPUT

struct PxrSwitch {
  static constexpr float kBlack[3] = {0, 0, 0};
  // Whether element k is said by itself: parameters of their own are -1 where they are not.
  static bool isSaid(const Context& c, uint32_t k) {
    if (k >= kMost) return false;
    if (c.isConnected(kElement0 + k)) return true;
    const Value v = c.param(kElement0 + k);
    return v.data[0][0] != -1.f || v.data[1][0] != -1.f || v.data[2][0] != -1.f;
  }
  struct Elements {
    const float* list;
    uint32_t listed, count;
    explicit Elements(const Context& c) {
      listed = c.fn->list(&c, kInputsRGB, &list) / 3;
      count = listed;
      for (uint32_t k = listed; k < kMost; ++k)
        if (isSaid(c, k)) count = k + 1;
    }
  };
  // Element k: what is connected to it, else what the list says; black in gaps.
  static Value element(const Context& c, const Elements& elements, uint32_t k) {
    if (isSaid(c, k)) return c.param(kElement0 + k);
    return constantValue(c, 3, k < elements.listed ? elements.list + 3 * k : kBlack);
  }
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const Value index = c->param(kIndex);
    const Elements elements(*c);
    const uint32_t n = elements.count;
    Value& out = args->outputs[0];
    if (n == 0) {
      out = constantValue(*c, 3, kBlack);
    } else if (index.uniform() || n == 1) {
      // one element is asked for, the others' networks need not run
      const float x = index.data[0][0], whole = toNearestWhole(x, float(n));
      out = element(*c, elements, uint32_t(whole));
    } else {
      float* rgb[3];
      makeOutput(*c, out, 3, false, rgb);
      Value* values = c->alloc<Value>(n);
      for (uint32_t k = 0; k < n; ++k) values[k] = element(*c, elements, k);
      for (uint32_t i = 0; i < c->padded; i += W) {
        const At at{i, false};
        const F whole = wrapped(loadFloat<W>(index, at), F(float(n)));
        Rgb<W> color;
        for (uint32_t k = 0; k < n; ++k) color = select(whole == F(float(k)), loadRgb<W>(values[k], at), color);
        color.store(rgb, i);
      }
    }
    shareComponents(*args, 0);
  }
  template <int W>
  static KN_INLINE Float<W> wrapped(Float<W> x, Float<W> n) {
    using F = Float<W>;
    x = floor(clamp(x, F(-8e6f), F(8e6f)) + F(0.5f));
    return clamp(fnma(floor(x / n), n, x), F(0.f), n - F(1.f));
  }
  static float toNearestWhole(float x, float n) { return wrapped(Float<1>(x), Float<1>(n)).lane0(); }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrSwitch, .help = "One of a list of colours, by number.", .params = kParams)
