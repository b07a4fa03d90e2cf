// PxrDot: the scalar product of two vectors as they are.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrDot/PxrDot.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kVector1, kVector2 };
constexpr Param kParams[] = {
    param::vector("vector1", 0, 0, 0).help("First factor."),
    param::vector("vector2", 0, 0, 0).help("Second factor."),
    param::output(Type::Float, "result"),
    param::output(Type::Float, "resultF"),
};

struct PxrDot {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const Value a = c->param(kVector1), b = c->param(kVector2);
    const bool one = allUniform({&a, &b});
    float* out[3];
    makeOutput(*c, args->outputs[0], 1, one, out);
    for (uint32_t i = 0; i < extent(*c, one); i += W) {
      const At at{i, false};
      dot(loadVec<W>(a, at), loadVec<W>(b, at)).store(out[0] + i);
    }
    args->outputs[1] = args->outputs[0];
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrDot, .help = "The dot product of two vectors.", .params = kParams)
