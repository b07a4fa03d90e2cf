// PxrVCM with beams in media alone, beside light that is met by chance; with a share of theirs that leaves the sine out
// (vcm::Options::withoutSine) vcm_media_test.cpp must notice. And connections without what media let through in theirs.
#define KINORA_STOCK_PLUGIN
#define KINORA_KERNEL_FILE "tests/probes/wrong_beams.cpp"
#include <kinora/integrator_author.h>

#include "plugins/integrator/parts/vcm_kernel.h"

#if KINORA_PLAIN
namespace kinora::wrongBeams {
enum : uint32_t { kMediaRadius, kIsWrong };
constexpr Param kParams[] = {
    param::number("mediaRadius", 2.f).range(0.01f, 1000).help("As of PxrVCM; all passes have it."),
    param::integer("isWrong", 0)
        .range(0, 2)
        .help("1: beams leave the sine out of their share; 2: connections, in place of beams, the transmittance."),
};
struct Data : vcm::Options {
  explicit Data(const CreateInfo& info) {
    bounces = 4;
    lightSamples = 0;
    connects = merges = false;
    beams = true;
    mediaRadius = info.number(kMediaRadius);
    mediaReduce = 1;
    clampLuminance = 1e30f;
    withoutSine = info.integer(kIsWrong) == 1;
    if (info.integer(kIsWrong) == 2) {
      lightSamples = 1;
      connects = withoutEdge = true;
      beams = false;
    }
  }
};
inline uint32_t stages(const void* data, Stage* out, uint32_t capacity) {
  return vcm::stages(*static_cast<const Data*>(data), out, capacity);
}
inline uint32_t lists(const void* data, RecordList* out, uint32_t) {
  return vcm::lists(*static_cast<const Data*>(data), out);
}
}  // namespace kinora::wrongBeams
#endif

KINORA_KERNELS_BEGIN
struct WrongBeams {
  using Data = wrongBeams::Data;
  template <int W>
  static void integrate(const Data& data, uint32_t, Group& group, const Services& services) {
    Vcm<W>(&group, &services, data).run();
  }
  static void commit(const Data& data, uint32_t stage, const CommitServices& services) {
    Vcm<1>::commit(data, stage, services);
  }
};
KINORA_KERNELS_END

KINORA_INTEGRATOR(WrongBeams, .help = "Beams whose share leaves the sine out.", .params = wrongBeams::kParams,
                  .setUp = setUp<wrongBeams::Data>, .stages = wrongBeams::stages, .lists = wrongBeams::lists,
                  .passSamples = 1, .scattersInMedia = scatterInMedia)
