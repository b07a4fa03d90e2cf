// PxrConstant: a flat colour, the same from all sides, whatever the light. It scatters nothing.
#define KINORA_KERNEL_FILE "plugins/bxdf/PxrConstant/PxrConstant.cpp"
#include <kinora/bxdf_author.h>

KINORA_KERNELS_BEGIN

constexpr const char* kAsItIs[] = {"", nullptr};
enum : uint32_t { kEmitColor, kPresence };
constexpr Param kParams[] = {
    param::color("emitColor", 1.f).range(0, 10).help("Radiance given off, on both sides."),
    param::number("presence", 1.f).help("Existence of the surface: 0 is a hole."),
};

struct PxrConstant {
  struct Closure {
    Value emit;
  };
  template <int W>
  using HasEmission = void;
  static void begin(const Context& c, Closure& k) { k.emit = c.param(kEmitColor); }
  static void presence(const Context* c, float* out) { copyFloat(c->param(kPresence), c->padded, out); }
  template <int W>
  static KN_INLINE Rgb<W> emission(const Closure& k, At at) {
    return loadRgb<W>(k.emit, at);
  }
  template <int W>
  struct Lanes {
    Rgb<W> color;
    KN_INLINE Lanes(const Closure& k, const Surface<W>& s) : color(loadRgb<W>(k.emit, s.at)) {}
    KN_INLINE void evaluate(Vec3<W>, LobeSum<W>&) const {}
    KN_INLINE void sample(Float<W>, Float<W>, Float<W>, LobeSample<W>& out) const {
      out.wi = Vec3<W>(Float<W>(0.f), Float<W>(0.f), Float<W>(1.f));
      out.valid = out.discrete = Mask<W>(false);
    }
    // For the denoiser: the colour stands for the surface, clamped as any albedo.
    KN_INLINE Rgb<W> albedo() const {
      const Float<W> none(0.f), one(1.f);
      return {clamp(color.x, none, one), clamp(color.y, none, one), clamp(color.z, none, one)};
    }
  };
};

KINORA_KERNELS_END

KINORA_BXDF(PxrConstant, .help = "A constant colour, unlit.", .params = kParams, .presenceParam = kPresence,
            .conserving = kAsItIs)
