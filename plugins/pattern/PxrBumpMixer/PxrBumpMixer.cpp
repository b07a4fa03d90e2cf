// PxrBumpMixer: adds bumps. They are handed on as surface gradients, which add; bumps that arrive as normals become
// gradients first.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrBumpMixer/PxrBumpMixer.cpp"
#include <kinora/pattern_author.h>

#include "plugins/pattern/slopes/surface_gradient.h"

KINORA_KERNELS_BEGIN

enum : uint32_t { kFirst, kPerBump = 3, kBumps = 5, kInputN = kFirst + kBumps * kPerBump, kDisable };
#define KINORA_BUMP(n)                                                                                              \
  structural(param::vector("surfaceGradient" #n, 0, 0, 0)).help("Slope of bump " #n ": resultNG of another node."), \
      param::normal("inputN" #n).help("Bump " #n " as a normal, where there is no surface gradient."),              \
      param::number("amount" #n, 1.f).range(-2, 2).help("How much of bump " #n " is added.")
constexpr Param kParams[] = {
    KINORA_BUMP(1),
    KINORA_BUMP(2),
    KINORA_BUMP(3),
    KINORA_BUMP(4),
    KINORA_BUMP(5),
    param::normal("inputN").help("Normal that the bumps bend; the surface's where it is 0 0 0."),
    param::flag("disable", false).help("1: the normal stays as it is."),
    param::output(Type::Normal, "resultN"),
    param::output(Type::Vector, "resultNG"),
};
#undef KINORA_BUMP

struct PxrBumpMixer {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    const Value base = c->param(kInputN);
    const bool given = isBumped(base), off = fixedInteger(*c, kDisable) != 0;
    // only what is there is asked for: the rest of the network need not run
    Value slopes[kBumps], normals[kBumps], amounts[kBumps];
    for (uint32_t k = 0; !off && k < kBumps; ++k) {
      slopes[k] = c->param(kFirst + kPerBump * k);
      if (!isBumped(slopes[k])) normals[k] = c->param(kFirst + kPerBump * k + 1);
      if (isBumped(slopes[k]) || isBumped(normals[k])) amounts[k] = c->param(kFirst + kPerBump * k + 2);
    }
    float *out[3], *gradient[3];
    makeOutput(*c, args->outputs[0], 3, false, out);
    makeOutput(*c, args->outputs[1], 3, false, gradient);
    for (uint32_t i = 0; i < c->padded; i += W) {
      const At at{i, false};
      const Surface<W> s(*c, at);
      Vec3<W> sum;
      for (uint32_t k = 0; k < kBumps; ++k) {
        if (!amounts[k].components) continue;
        Vec3<W> g;
        if (isBumped(slopes[k])) {
          g = loadVec<W>(slopes[k], at);
        } else {
          const Vec3<W> own = loadVec<W>(normals[k], at);
          g = select(dot(own, own) > Float<W>(1e-12f), surfaceGradient(bumpedNormal<W>(normals[k], s), s.N), g);
        }
        sum += g * loadFloat<W>(amounts[k], at);
      }
      sum.store(gradient, i);
      const Vec3<W> n = given ? bumpedNormal<W>(base, s) : s.N;
      normalize(n - sum).store(out, i);
    }
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrBumpMixer, .help = "Adds up to five bumps.", .params = kParams)
