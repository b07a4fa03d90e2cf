// PxrOrthographic: parallel rays along the view axis; the screen window is in units of camera space. No depth of
// field. RIB's Projection "orthographic" is this one.
//
// Light paths: rays have one direction, so there is no density per solid angle; what exists is one per area, 1 / A at
// the screen with A the area of a pixel, cos(X) / A on a surface at X. connect() returns for importance and pdf alike
// r^2 / A, r being the distance it reports (from X straight back to the eye's plane): the host's usual conversions
// cos / r^2 then give exactly the splat f(X) cos(X) / A and the density cos(X) / A, with no case of its own.
#define KINORA_KERNEL_FILE "plugins/projection/PxrOrthographic/PxrOrthographic.cpp"
#include <kinora/projection_setup.h>
#include <memory>
#include <kinora/projection_author.h>

#if KINORA_PLAIN
namespace kinora::pxrOrthographic {
struct Data {
  ScreenMap screen;
  float nearClip = 0, farClip = 0;
};

std::unique_ptr<Data> make(const CreateInfo& info) {
  const auto* projection = static_cast<const ProjectionInfo*>(info.extra);
  auto data = std::make_unique<Data>();
  data->screen = ScreenMap::of(projection);
  data->nearClip = projection->clipping[0];
  data->farClip = projection->clipping[1];
  return data;
}
void ndcMatrix(const void* data, double out[16]) {
  screenToNdc(static_cast<const Data*>(data)->screen, 1, false, out);
}
}  // namespace kinora::pxrOrthographic
#endif

KINORA_KERNELS_BEGIN
using namespace pxrOrthographic;

struct PxrOrthographic {
  using Data = pxrOrthographic::Data;
  template <int W>
  static KN_INLINE void rays(const Data& k, const CameraSample<W>& in, CameraRay<W>& out) {
    using F = Float<W>;
    toScreen(k.screen, in.x, in.y, out.o.x, out.o.y);
    out.o.z = F(0.f);
    out.d = Vec3<W>(F(0.f), F(0.f), F(1.f));
    out.weight = F(1.f);
    out.radius = F(0.5f) * sqrt(F(k.screen.pixelArea()));
    out.spread = F(0.f);
  }
  template <int W>
  static KN_INLINE void connect(const Data& k, const CameraPoint<W>& in, CameraLink<W>& out) {
    using F = Float<W>;
    out.o = Vec3<W>(in.P.x, in.P.y, F(0.f));
    toRaster(k.screen, in.P.x, in.P.y, out.x, out.y);
    Mask<W> seen = (in.P.z > F(0.f)) & insideRaster(k.screen, out.x, out.y);
    if (k.farClip > 0) seen &= (in.P.z >= F(k.nearClip)) & (in.P.z <= F(k.farClip));
    out.importance = zeroUnless(seen, in.P.z * in.P.z * F(1.f / k.screen.pixelArea()));
    out.pdf = out.importance;
  }
};
KINORA_KERNELS_END

KINORA_PROJECTION(PxrOrthographic, .help = "Parallel rays along the view axis.", .setUp = setUpBy<make>,
                  .ndcMatrix = ndcMatrix)
