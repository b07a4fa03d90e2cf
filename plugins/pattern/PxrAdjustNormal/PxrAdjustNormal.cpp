// PxrAdjustNormal: bends normals that look away from the viewer until they are seen, by a share, and mixes in the
// surface's own.
#define KINORA_KERNEL_FILE "plugins/pattern/PxrAdjustNormal/PxrAdjustNormal.cpp"
#include <kinora/pattern_author.h>

KINORA_KERNELS_BEGIN

enum : uint32_t { kInputNormal, kAdjustAmount, kSurfaceNormalMix };
constexpr Param kParams[] = {
    param::normal("inputNormal").help("Normal to adjust; the surface's where it is 0 0 0."),
    param::number("adjustAmount", 1.f).help("0: as it is, 1: bent until the viewer sees it."),
    param::number("surfaceNormalMix", 0.f).help("Share of the surface's own normal."),
    param::output(Type::Normal, "resultN"),
};

struct PxrAdjustNormal {
  template <int W>
  static void compute(const Context* c, const PatternArgs* args) {
    using F = Float<W>;
    const Value in = c->param(kInputNormal), amount = c->param(kAdjustAmount), mix = c->param(kSurfaceNormalMix);
    const bool given = isBumped(in);
    float* out[3];
    makeOutput(*c, args->outputs[0], 3, false, out);
    for (uint32_t i = 0; i < c->padded; i += W) {
      const At at{i, false};
      const Surface<W> s(*c, at);
      if (!given) {
        s.N.store(out, i);
        continue;
      }
      Vec3<W> n = loadVec<W>(in, at);
      const F l = length(n);
      n = select(l > F(1e-6f), n * (F(1.f) / max(l, F(1e-6f))), s.N);
      n = lerp(n, bumpedNormal<W>(in, s), loadFloat<W>(amount, at));
      n = lerp(n, s.N, loadFloat<W>(mix, at));
      const F m = length(n);
      select((l > F(1e-6f)) & (m > F(1e-6f)), n * (F(1.f) / max(m, F(1e-6f))), s.N).store(out, i);
    }
  }
};

KINORA_KERNELS_END

KINORA_PATTERN(PxrAdjustNormal, .help = "Bends normals that the viewer would not see.", .params = kParams)
