// PxrDefault: every surface lit from the eye, for a first look at scenes without lights. No shadows, no bounces: the
// bxdf answers for light coming from where it is seen (radiance pi, so that a white diffuse surface facing the eye is
// white).
#define KINORA_KERNEL_FILE "plugins/integrator/PxrDefault/PxrDefault.cpp"
#include <kinora/integrator_author.h>
#include <kinora/camera_hits.h>

KINORA_KERNELS_BEGIN

struct Runner {
  template <int W>
  static void integrate(const void*, uint32_t, Group* g, const Services* sv) {
    const CameraHits hits(g, sv);
    for (uint32_t k = 0; k < hits.contextCount; ++k) {
      const Context& c = *hits.contexts[k];
      EvaluateArgs e{};
      for (int x = 0; x < 3; ++x) e.wi[x] = c.wo[x];
      for (uint32_t l = 0; l < c.slotCount; ++l)
        for (float*& row : e.weight[l]) row = hits.floats(c.padded);
      e.pdf = hits.floats(c.padded);
      c.bxdf->evaluate(&c, c.closure, &e);
      for (uint32_t l = 0; l < c.slotCount; ++l) {
        for (float* row : e.weight[l])
          for (uint32_t i = 0; i < c.padded; ++i) row[i] *= kPi;
        hits.showSlot(c, l, e.weight[l]);
      }
      if (!c.bxdf->emission) continue;
      float* const glow[3] = {hits.floats(c.padded), hits.floats(c.padded), hits.floats(c.padded)};
      c.bxdf->emission(&c, c.closure, glow);
      hits.show(c, glow);
    }
  }
  template <int W>
  static constexpr IntegratorFunctions table() {
    return IntegratorFunctions{&integrate<W>};
  }
};

KINORA_KERNELS_END

KINORA_PLUGIN(PxrDefault, Runner, IntegratorPlugin,
              .help = "A headlight: each surface lit from the eye, for scenes without lights.")
