// PxrVCM with beams in media alone, beside light that is met by chance, whose share leaves the sine out: the tests of
// vcm_media_test.cpp must notice. And connections that leave out of theirs what media let through.
#define KINORA_STOCK_PLUGIN
#define KINORA_KERNEL_FILE "tests/probes/wrong_beams.cpp"
#include <kinora/integrator_author.h>

#include "plugins/integrator/parts/vcm_kernel.h"

#if KINORA_PLAIN
namespace kinora::wrongBeams {
enum : uint32_t { kMediaRadius, kIsWrong };
constexpr Param kParams[] = {
    param::number("mediaRadius", 2.f).range(0.01f, 1000).help("As of PxrVCM; all passes have it."),
    param::integer("isWrong", 1)
        .range(1, 2)
        .help("1: beams leave the sine out of their share; 2: connections, in place of beams, the transmittance."),
};
struct Data : vcm::Options {
  bool leavesSineOut;
  explicit Data(const CreateInfo& info) : leavesSineOut(info.integer(kIsWrong) == 1) {
    bounces = 4;
    lightSamples = leavesSineOut ? 0 : 1;
    connects = !leavesSineOut;
    merges = false;
    beams = leavesSineOut;
    mediaRadius = info.number(kMediaRadius);
    mediaReduce = 1;
    clampLuminance = 1e30f;
  }
};
}  // namespace kinora::wrongBeams
#endif

KINORA_KERNELS_BEGIN
struct WithoutSine : VcmShares {
  static float ofCrossing(float) { return 1; }
};
struct WithoutTransmittance : VcmShares {
  template <int W>
  static KN_INLINE Float<W> ofConnection(Float<W>) {
    return Float<W>(1.f);
  }
};
struct WrongBeams : RunsVcm<wrongBeams::Data> {
  template <int W>
  static void integrate(const Data& data, uint32_t, Group& group, const Services& services) {
    if (data.leavesSineOut)
      Vcm<W, WithoutSine>(&group, &services, data).run();
    else
      Vcm<W, WithoutTransmittance>(&group, &services, data).run();
  }
};
KINORA_KERNELS_END

KINORA_INTEGRATOR(WrongBeams, .help = "Beams or connections whose share is wrong.", .params = wrongBeams::kParams,
                  .setUp = setUp<wrongBeams::Data>, .stages = vcm::stagesOf<wrongBeams::Data>,
                  .lists = vcm::listsOf<wrongBeams::Data>, .passSamples = 1, .scattersInMedia = scatterInMedia)
