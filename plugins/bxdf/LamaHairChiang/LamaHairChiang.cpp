// LamaHairChiang: hair and fur by Chiang, Bitterli, Tappan and Burley, "A Practical and Controllable Hair and Fur Model
// for Production Path Tracing" (EGSR 2016): reflection (R), light that goes through (TT), that is reflected inside (TRT)
// and all longer paths, for the offset across the width at which a ray meets the fibre. Roughnesses are perceptual, and
// the absorption is found from the colour that hair as a whole should have. Of its published names there are colorR,
// colorTT, colorTintTT, offset and IOR; the others, the units and the defaults are chosen here after the paper.
//
// As PxrMarschnerHair has it, what leaves stands for the whole passage (kBxdfFiber), energy is conserved for light
// that is followed from the eye, and light paths take the adjoint. Directions are made by path and exactly by its lobes.
#define KINORA_KERNEL_FILE "plugins/bxdf/LamaHairChiang/LamaHairChiang.cpp"
#include <kinora/bxdf_author.h>

#include "plugins/bxdf/hair/chiang.h"
#include "plugins/bxdf/lama/bind.h"

KINORA_KERNELS_BEGIN

enum : uint32_t {
  kColorMode,  // and those of hair::ChiangClosure behind it
  kPresence = hair::kChiangParams
};
constexpr Param kParams[] = {KINORA_HAIR_CHIANG_PARAMS("", ""),
                             param::number("presence", 1.f).help("Existence of the surface: 0 is a hole."),
                             KINORA_LAMA_COMMON_OF("No effect: hair has no bumps.", KINORA_LAMA_LOBE_NAME)};

// Each scatters to both sides of the surface; one follows the other.
constexpr LobeDecl kLobes[] = {
    {"=lobeName:HairSpecularR", kLobeSpecular},   {"=lobeName:HairSpecularR", kLobeSpecular | kLobeTransmit},
    {"=lobeName:HairSpecularTT", kLobeSpecular},  {"=lobeName:HairSpecularTT", kLobeSpecular | kLobeTransmit},
    {"=lobeName:HairSpecularTRT", kLobeSpecular}, {"=lobeName:HairSpecularTRT", kLobeSpecular | kLobeTransmit}};
constexpr const char* kLossless[] = {
    "colorTT=1 1 1", "colorMode=2; absorption=0 0 0; longitudinalRoughness=0.1; azimuthalRoughness=0.1; offset=5",
    "colorMode=1; eumelanin=0; longitudinalRoughness=1; azimuthalRoughness=1; IOR=1.3",
    "colorTT=1 1 1; longitudinalRoughness=0.6; azimuthalRoughness=0.8; offset=0; IOR=1.8", nullptr};
constexpr const char* kConserving[] = {"", "colorMode=1; eumelanin=0.3; pheomelanin=1", nullptr};

struct LamaHairChiang {
  using Closure = hair::ChiangClosure;
  static void begin(const Context& c, Closure& k) { k.bind(c, kColorMode); }
  static void presence(const Context* c, float* out) { copyFloat(c->param(kPresence), c->padded, out); }

  template <int W>
  struct Lanes {
    ChiangFiber<W> fiber;
    KN_INLINE Lanes(const Closure& k, const Surface<W>& s) : fiber(k, s) {}
    KN_INLINE void evaluate(Vec3<W> wi, LobeSum<W>& out) const {
      FiberDensity<W> forward, back;
      evaluateFiber(fiber, wi, Float<W>(1.f), 0, out, forward, back);
      out.pdf = forward.mean();
      out.pdfReverse = back.mean();
    }
    KN_INLINE void sample(Float<W> u, Float<W> v, Float<W> w, LobeSample<W>& out) const {
      fiber.sample(u, v, w, out);
    }
    KN_INLINE Rgb<W> albedo() const { return fiber.albedo(); }
  };
};

KINORA_KERNELS_END

KINORA_BXDF(LamaHairChiang,
            .help = "Hair and fur by Chiang et al.: perceptual roughnesses, and a colour that hair has as a whole.",
            .params = kParams, .lobes = kLobes, .presenceParam = kPresence, .lossless = kLossless,
            .conserving = kConserving, .flags = kBxdfNotReciprocal | kBxdfFiber)
