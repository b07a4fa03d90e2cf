// PxrBlack: absorbs all light. For hold-outs and objects that only cast shadows; presence is always 1.
#define KINORA_KERNEL_FILE "plugins/bxdf/PxrBlack/PxrBlack.cpp"
#include <kinora/bxdf_author.h>

KINORA_KERNELS_BEGIN

constexpr const char* kAsItIs[] = {"", nullptr};

struct PxrBlack {
  struct Closure {};
  static void begin(const Context&, Closure&) {}
  template <int W>
  struct Lanes {
    KN_INLINE Lanes(const Closure&, const Surface<W>&) {}
    KN_INLINE void evaluate(Vec3<W>, LobeSum<W>&) const {}
    KN_INLINE void sample(Float<W>, Float<W>, Float<W>, LobeSample<W>& out) const {
      out.wi = Vec3<W>(Float<W>(0.f), Float<W>(0.f), Float<W>(1.f));
      out.valid = out.discrete = Mask<W>(false);
    }
    KN_INLINE Rgb<W> albedo() const { return Rgb<W>(); }
  };
};

KINORA_KERNELS_END

KINORA_BXDF(PxrBlack, .help = "Absorbs all light.", .conserving = kAsItIs)
