// PxrPortalLight: the part of a dome that is seen through a rectangle. It emits what the dome has in each direction
// through it; sampled evenly over the rectangle's solid angle. The renderer gives it the scene's dome where the file
// does not say which one (render/portals.h), and that dome then shines through its portals alone.
#define KINORA_KERNEL_FILE "plugins/light/PxrPortalLight/PxrPortalLight.cpp"
#include <kinora/light_setup.h>
#include <memory>
#include <kinora/light_author.h>

#include "plugins/light/parts/dome_map.h"
#include "plugins/light/parts/grey_sky.h"
#include "plugins/light/parts/rectangle_kernel.h"

#if KINORA_PLAIN
namespace kinora::pxrPortalLight {
constexpr float kIdentity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
constexpr std::array kPortal = {
    param::string("domeColorMap", "")
        .file()
        .help("The dome's latitude-longitude map; empty: that of the scene's dome, or none."),
    lightParams::kMap[1],  // colorMapGamma
    lightParams::kMap[2],  // colorMapSaturation
    param::array(Type::Float, "portalToDome", kIdentity, 16)
        .help("Matrix from the portal's local space to the dome's, row-vector; rotation and mirroring count. As a "
              "matrix or 16 numbers."),
    param::number("intensityMult", 1.f).range(0, 10).help("Factor on the dome's radiance."),
    param::color("tint", 1.f).help("Factor on the dome's colour."),
    param::string("portalName", "").help("Accepted: tells portals apart for the host that writes them."),
};
constexpr auto kParams = joinParams(lightParams::kRadiance, kPortal, lightParams::kControl);

struct Data : lightParts::Rectangle {
  Float3 domeX, domeY, domeZ;  // the dome's local axes in render space: orthonormal, perhaps left-handed
};

// The matrix's rows are the portal's axes as the dome has them; their lengths, the portal's size, say nothing of
// directions. False where nothing is left of these.
bool setDomeAxes(const LocalFrame& f, const float* toDome, Data& k) {
  const Double3 local[3] = {normalized(f.x), normalized(f.y), normalized(f.z)};
  Double3 axis[3];
  for (int i = 0; i < 3; ++i) {
    const Double3 row = normalized({toDome[4 * i], toDome[4 * i + 1], toDome[4 * i + 2]});
    const double parts[3] = {row.x, row.y, row.z};
    for (int j = 0; j < 3; ++j) axis[j] = axis[j] + local[i] * parts[j];
  }
  for (Double3& a : axis) a = normalized(a);
  const Double3 z = axis[2], y = normalized(axis[1] - z * dot(axis[1], z));
  Double3 x = cross(y, z);
  if (dot(x, axis[0]) < 0) x = x * -1;
  k.domeX = Float3(x);
  k.domeY = Float3(y);
  k.domeZ = Float3(z);
  return length(z) > 0.5 && length(y) > 0.5 && std::fabs(dot(x, axis[0])) > 1e-6;
}

std::unique_ptr<Data> make(const CreateInfo& info) {
  const NamedValues values(info, kParams.data(), kParams.size());
  const LocalFrame frame = LocalFrame::of(info);
  auto light = std::make_unique<Data>();
  light->common = LightCommon::of(values, -1);
  for (int c = 0; c < 3; ++c)
    light->common.radiance[c] *= float(values.number("intensityMult") * values.number("tint", c));
  light->map.load(values, "domeColorMap");
  lightParts::greySkyWithout(light->map, "domeColorMap", values, light->common);
  values.warnNoEffect();
  light->place(values, frame);
  if (!(light->area > 0)) return light;
  const ParamValue& matrix = info.values[values.index("portalToDome")];
  bool isMatrix = matrix.count == 16;
  for (uint32_t i = 0; i < matrix.count && isMatrix; ++i) isMatrix = std::isfinite(matrix.floats[i]);
  if (!setDomeAxes(frame, isMatrix ? matrix.floats : kIdentity, *light) || !isMatrix) {
    values.warn("LIGHT-PORTAL", "portalToDome is no matrix that turns", "the dome stands as the portal does");
    if (!setDomeAxes(frame, kIdentity, *light)) light->isBlack = true;
  }
  return light;
}

void describe(const void* data, LightDescription* d) { *d = lightParts::describe(*static_cast<const Data*>(data)); }
// Of an even dome; -1 where a map makes the radiance vary.
double irradiance(const void* data, const double P[3], const double N[3]) {
  return lightParts::irradiance(*static_cast<const Data*>(data), P, N);
}
}  // namespace kinora::pxrPortalLight
#endif

KINORA_KERNELS_BEGIN
using namespace pxrPortalLight;

struct PxrPortalLight : RectangleLight<PxrPortalLight, pxrPortalLight::Data> {
  template <int W>
  static KN_INLINE Rgb<W> radiance(const Lanes<W>& k, Vec3<W> wi, Float<W>, Float<W>, Float<W>) {
    const Rgb<W> l = k.of.rgb([](const Data& d) { return d.common.radiance; });
    if (!k.of.any([](const Data& d) { return d.map.valid(); })) return l;
    Float<W> u, v;
    toDomeMap(Vec3<W>(dot(wi, k.of(&Data::domeX)), dot(wi, k.of(&Data::domeY)), dot(wi, k.of(&Data::domeZ))), u, v);
    return l * lookUp<W, true>(k.of, u, v);
  }
};

KINORA_KERNELS_END

KINORA_LIGHT(PxrPortalLight,
             .help =
                 "The part of a dome that is seen through a rectangle, the unit square of the local XY plane, which "
                 "lights the side of local +Z. Without parameters of its own it shows the scene's dome, which then "
                 "shines through its portals alone.",
             .params = kParams, .setUp = setUpBy<make>, .describe = describe, .irradiance = irradiance)
