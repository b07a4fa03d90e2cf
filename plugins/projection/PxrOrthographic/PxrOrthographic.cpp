// PxrOrthographic: parallel rays along the view axis; the screen window is in units of camera space. RIB's Projection
// "orthographic" is this one.
//
// Depth of field: each place of the screen looks through a lens of its own around it, as behind a telecentric one. With
// o the lens point and F the distance of the plane of focus, rays of the place s begin at s + o and go along
// (-o / F, 1): at depth z they are at s + o (1 - z / F).
//
// Light paths: rays of one lens point have one direction, so there is no density per solid angle; what exists is one per
// area, 1 / A on planes that face the camera with A the area of a pixel, cos(X) / (A cos) on a surface at X, where cos is
// that of the direction to the view axis: 1 without a lens. connect() returns for importance and pdf alike
// r^2 / (A cos), r being the distance it reports (from X back along the ray to the eye's plane): the host's usual
// conversions cos(X) / r^2 then give exactly the splat f(X) cos(X) / (A cos) and that density, with no case of its own.
#define KINORA_KERNEL_FILE "plugins/projection/PxrOrthographic/PxrOrthographic.cpp"
#include <kinora/projection_setup.h>
#include <memory>
#include <kinora/projection_author.h>
#include "plugins/projection/parts/requested_lens.h"

#if KINORA_PLAIN
namespace kinora::pxrOrthographic {
std::unique_ptr<ThinLens> make(const CreateInfo& info) {
  const auto* projection = static_cast<const ProjectionInfo*>(info.extra);
  auto data = std::make_unique<ThinLens>();
  data->screen = ScreenMap::of(projection);
  setRequestedLens(*data, *projection);
  data->nearClip = projection->clipping[0];
  data->farClip = projection->clipping[1];
  return data;
}
void ndcMatrix(const void* data, double out[16]) {
  screenToNdc(static_cast<const ThinLens*>(data)->screen, 1, false, out);
}
}  // namespace kinora::pxrOrthographic
#endif

KINORA_KERNELS_BEGIN
using namespace pxrOrthographic;

struct PxrOrthographic {
  using Data = ThinLens;
  // A ray's direction through a point of the lens, of unit z.
  template <int W>
  static KN_INLINE Vec3<W> direction(const Data& k, const Vec3<W>& lens) {
    return Vec3<W>(Float<W>(0.f), Float<W>(0.f), Float<W>(1.f)) - lens * Float<W>(k.sharp[2]);
  }
  template <int W>
  static KN_INLINE void rays(const Data& k, const CameraSample<W>& in, CameraRay<W>& out) {
    using F = Float<W>;
    toScreen(k.screen, in.x, in.y, out.o.x, out.o.y);
    out.o.z = F(0.f);
    out.d = Vec3<W>(F(0.f), F(0.f), F(1.f));
    F cosine(1.f);
    if (k.lensRadius > 0) {
      const Vec3<W> lens = ThinLensProjection::lensPoint<W>(k, in.lensU, in.lensV), d = direction<W>(k, lens);
      cosine = F(1.f) / length(d);
      out.o = out.o + lens;
      out.d = d * cosine;
    }
    out.weight = F(1.f);
    out.radius = F(0.5f) * sqrt(F(k.screen.pixelArea()) * cosine);  // of a pixel, across the ray
    out.spread = F(0.f);
  }
  template <int W>
  static KN_INLINE void connect(const Data& k, const CameraPoint<W>& in, CameraLink<W>& out) {
    using F = Float<W>;
    F x = in.P.x, y = in.P.y, secant(1.f);
    out.o = Vec3<W>(x, y, F(0.f));
    if (k.lensRadius > 0) {
      const Vec3<W> lens = ThinLensProjection::lensPoint<W>(k, in.lensU, in.lensV);
      const F across = fnma(in.P.z, F(k.sharp[2]), F(1.f));
      x = fnma(lens.x, across, x);
      y = fnma(lens.y, across, y);
      out.o = Vec3<W>(x + lens.x, y + lens.y, F(0.f));
      secant = length(direction<W>(k, lens));
    }
    toRaster(k.screen, x, y, out.x, out.y);
    Mask<W> seen = (in.P.z > F(0.f)) & insideRaster(k.screen, out.x, out.y);
    if (k.farClip > 0) seen &= (in.P.z >= F(k.nearClip)) & (in.P.z <= F(k.farClip));
    out.importance = zeroUnless(seen, in.P.z * in.P.z * F(1.f / k.screen.pixelArea()) * (secant * secant * secant));
    out.pdf = out.importance;
  }
};
KINORA_KERNELS_END

KINORA_PROJECTION(PxrOrthographic,
                  .help =
                      "Parallel rays along the view axis. The DepthOfField request acts: the lens is as wide as its "
                      "focal length by its f-stop, in units of camera space, around each place of the picture; its "
                      "shape is the Camera request's.",
                  .setUp = setUpBy<make>, .ndcMatrix = ndcMatrix)
