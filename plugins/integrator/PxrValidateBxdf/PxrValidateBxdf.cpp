// PxrValidateBxdf: shows where a material's two halves disagree. At each camera hit directions are generated and
// evaluated again. Green: the albedo that the samples estimate (a white furnace: energy appears where it is above 1).
// Red: the mean relative difference of the densities that generate and evaluate give for the same direction (of
// continuous lobes, and of the weights where the picture does not tell lobes apart). Blue: samples that are broken:
// not finite, no unit direction, negative density. A sound material is pure green.
#define KINORA_KERNEL_FILE "plugins/integrator/PxrValidateBxdf/PxrValidateBxdf.cpp"
#include <cmath>
#include <kinora/integrator_author.h>
#include <kinora/camera_hits.h>

#if KINORA_PLAIN
namespace kinora::pxrValidateBxdf {
constexpr Param kParams[] = {
    param::integer("numSamples", 4).range(1, 64).help("Directions from each camera hit."),
};
struct Data {
  uint32_t samples = 4;
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const int samples = info.integer(0);
  return std::make_unique<Data>(Data{uint32_t(samples < 1 ? 1 : samples > 4096 ? 4096 : samples)});
}
}  // namespace kinora::pxrValidateBxdf
#endif

KINORA_KERNELS_BEGIN
using namespace pxrValidateBxdf;

struct PxrValidateBxdf {
  using Data = pxrValidateBxdf::Data;
  template <int W>
  static void check(const Data& k, const CameraHits& hits, const Context& c, uint32_t part, float* const rgb[3]) {
    GenerateArgs g{};
    EvaluateArgs e{};
    float* u[4];
    hits.bxdfNumbers<W>(c, part, k.samples, u);
    for (int x = 0; x < 4; ++x) g.u[x] = u[x];
    for (int x = 0; x < 3; ++x) {
      g.wi[x] = hits.floats(c.padded);
      g.weight[x] = hits.floats(c.padded);
    }
    g.pdf = hits.floats(c.padded);
    g.slot = hits.words(c.padded);
    g.flags = hits.words(c.padded);
    c.bxdf->generate(&c, c.closure, &g);
    // evaluate wants sound directions everywhere
    float* wi[3] = {hits.floats(c.padded), hits.floats(c.padded), hits.floats(c.padded)};
    uint32_t* state = hits.words(c.padded);  // 0 no sample, 1 sound, 2 broken
    for (uint32_t i = 0; i < c.padded; ++i) {
      const float l2 = g.wi[0][i] * g.wi[0][i] + g.wi[1][i] * g.wi[1][i] + g.wi[2][i] * g.wi[2][i];
      const bool finite =
          std::isfinite(g.weight[0][i]) && std::isfinite(g.weight[1][i]) && std::isfinite(g.weight[2][i]);
      const bool none = g.slot[i] == kNoLobe || g.pdf[i] == 0;
      state[i] = none ? 0 : std::fabs(l2 - 1) < 1e-4f && finite && g.pdf[i] > 0 && std::isfinite(g.pdf[i]) ? 1 : 2;
      for (int x = 0; x < 3; ++x) wi[x][i] = state[i] == 1 ? g.wi[x][i] : c.N[x][i];
    }
    for (int x = 0; x < 3; ++x) e.wi[x] = wi[x];
    for (uint32_t l = 0; l < c.slotCount; ++l)
      for (int x = 0; x < 3; ++x) e.weight[l][x] = hits.floats(c.padded);
    e.pdf = hits.floats(c.padded);
    c.bxdf->evaluate(&c, c.closure, &e);
    const float share = 1.f / float(k.samples);
    for (uint32_t i = 0; i < c.count; ++i) {
      if (state[i] == 2) rgb[2][i] += share;
      if (state[i] != 1) continue;
      rgb[1][i] +=
          share * (0.2126f * g.weight[0][i] + 0.7152f * g.weight[1][i] + 0.0722f * g.weight[2][i]) / g.pdf[i];
      if (g.flags[i] & kSampleDiscrete) continue;
      float off = std::fabs(e.pdf[i] - g.pdf[i]) / g.pdf[i];
      if (c.slotCount == 1)
        for (int x = 0; x < 3; ++x) {
          const float most = std::fmax(std::fabs(g.weight[x][i]), 1e-6f * g.pdf[i]);
          off = std::fmax(off, std::fabs(e.weight[0][x][i] - g.weight[x][i]) / most);
        }
      // rounding is no disagreement
      rgb[0][i] += off > 1e-3f ? share * std::fmin(off, 10.f) : 0.f;
    }
  }

  template <int W>
  static void integrate(const Data& k, uint32_t, Group& group, const Services& services) {
    const CameraHits hits(&group, &services);
    hits.showAll([&](const Context& c, float* const rgb[3]) {
      for (uint32_t part = 0; part < k.samples; ++part) check<W>(k, hits, c, part, rgb);
    });
  }
};

KINORA_KERNELS_END

KINORA_INTEGRATOR(PxrValidateBxdf,
                  .help =
                      "Shows where materials are unsound: red densities that disagree, green the albedo, blue broken "
                      "samples. A sound material is pure green.",
                  .params = kParams, .setUp = setUpBy<make>)
