// PxrPerspective: a pinhole or thin-lens camera. RIB's Projection "perspective" is this one. Importance and densities
// are derived in projection_author.h.
#define KINORA_KERNEL_FILE "plugins/projection/PxrPerspective/PxrPerspective.cpp"
#include <kinora/projection_setup.h>
#include <memory>
#include <kinora/simd/foreach_target.h>
#include <kinora/projection_author.h>

HWY_BEFORE_NAMESPACE();
namespace kinora {
namespace HWY_NAMESPACE {
namespace {
using Runner = ProjectionRunner<ThinLensProjection>;
KINORA_WIDTH_TABLES(Runner, ProjectionFunctions)
}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kinora
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kinora {
namespace {
constexpr auto kParams = joinParams(projectionParams::kLens);

void* create(const CreateInfo* info, ErrorText* error) {
  return guardedCreate(error, [&]() -> void* {
    const NamedValues values(*info, kParams.data(), kParams.size());
    const auto* projection = static_cast<const ProjectionInfo*>(info->extra);
    auto lens = std::make_unique<ThinLens>();
    lens->screen = ScreenMap::of(projection);
    setLens(*lens, values, *projection);
    return lens.release();
  });
}
constexpr ProjectionTraits kTraits{
    [](const void* data, double out[16]) { perspectiveMatrix(*static_cast<const ThinLens*>(data), out); }};
const WidthTable kTables[] = KINORA_ALL_WIDTHS;
const Descriptor kDescriptor{kAbiVersion,
                             sizeof(Descriptor),
                             Kind::Projection,
                             0,
                             "PxrPerspective",
                             "Perspective through a pinhole or a thin lens. Its shape is the Camera request's: "
                             "apertureNSides, apertureAngle, apertureRoundness, apertureDensity, dofaspect.",
                             kParams.data(),
                             uint32_t(kParams.size()),
                             kTables,
                             4,
                             &kTraits,
                             create,
                             [](void* d) { delete static_cast<ThinLens*>(d); }};
}  // namespace
KINORA_REGISTER(PxrPerspective, kDescriptor)
}  // namespace kinora
#endif
