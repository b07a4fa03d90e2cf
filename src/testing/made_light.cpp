#include "testing/made_light.h"

#include <cstring>

namespace kinora::testing {

namespace {
// Sky above, dark ground, and a small sun: what importance sampling of a map has to cope with.
const HostImage* testImage() {
  constexpr uint32_t kWidth = 32, kHeight = 16;
  static const std::vector<float> pixels = [] {
    std::vector<float> p;
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        const bool sun = y >= 4 && y < 6 && x >= 9 && x < 11;
        const float sky = y < kHeight / 2 ? 0.5f + 0.03f * float(x) : 0.05f;
        p.insert(p.end(), {sun ? 60.f : 0.6f * sky, sun ? 50.f : 0.8f * sky, sun ? 30.f : sky});
      }
    return p;
  }();
  static const HostImage image{pixels.data(), kWidth, kHeight, 3};
  return &image;
}
}  // namespace

TestMesh::TestMesh(const Placement& placement) {
  // A square and a triangle beside it, both looking along +Z: no part hides another, as the checks of emitted rays
  // take for granted, and none is seen edge-on alone.
  static constexpr double kPoints[7][3] = {{-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0.5, 0.5, 0}, {-0.5, 0.5, 0},
                                           {0.7, -0.3, 0},  {1.1, 0.1, 0},  {0.6, 0.4, 0}};
  static constexpr uint32_t kTriangles[9] = {0, 1, 2, 0, 2, 3, 4, 5, 6};
  for (const auto& p : kPoints)
    for (int c = 0; c < 3; ++c) {
      double sum = placement.localToRender[12 + c];
      for (int k = 0; k < 3; ++k) sum += p[k] * placement.localToRender[4 * k + c];
      points_.push_back(float(sum));
    }
  mesh = LightMesh{7, 3, points_.data(), kTriangles};
}

MadeLight::MadeLight(const Descriptor& d, const Setting& s, const Placement& placement)
    : descriptor_(d), mesh_(placement) {
  const ResolvedValues values(d, s);
  Host host{};
  host.warn = [](void*, const char*, const char*, const char*) {};  // settings at the ends of ranges may deserve it
  host.image = [](void*, const char* file, int) -> const HostImage* {
    return file && std::strcmp(file, kTestImage) == 0 ? testImage() : nullptr;
  };
  const CreateInfo info{&host, "light under test", values.data(), values.count(), &placement, &mesh_.mesh};
  ErrorText text{};
  data_ = d.create ? d.create(&info, &text) : nullptr;
  if (!data_) {
    error_ = d.create ? std::string("create() fails: ") + text.text : "has no create()";
    return;
  }
  static_cast<const LightTraits*>(d.traits)->describe(data_, &description_);
}

MadeLight::~MadeLight() {
  if (data_ && descriptor_.destroy) descriptor_.destroy(data_);
}

namespace {

// What the calls have alike; `inputs`: the rows before it are read, whole vectors of them.
template <class Arguments>
Arguments argumentsOf(Rows& a, uint32_t inputs, uint32_t time, const void* const* lights) {
  for (uint32_t r = 0; r < inputs; ++r) a.pad(r);
  Arguments s{};
  s.light = lights;
  s.count = a.count();
  s.time = a[time];
  s.worldRadius = kWorldRadius;
  return s;
}

}  // namespace

void LightSamples::run(const LightFunctions& f, const void* const* lights, bool byLane) {
  auto s = argumentsOf<LightSampleArgs>(a, kWi, kTime, lights);
  s.lightStride = byLane;
  for (uint32_t k = 0; k < 3; ++k) {
    s.P[k] = a[kP + k];
    s.wi[k] = a[kWi + k];
    s.radiance[k] = a[kRadiance + k];
  }
  s.u[0] = a[kU];
  s.u[1] = a[kU + 1];
  s.distance = a[kDistance];
  s.pdf = a[kPdf];
  s.flags = flags.data();
  f.sample(&s);
}

void LightRays::run(const LightFunctions& f, const void* const* lights, bool byLane, bool finite) {
  auto s = argumentsOf<LightRayArgs>(a, kT, kTime, lights);
  s.lightStride = byLane;
  for (uint32_t k = 0; k < 3; ++k) {
    s.o[k] = a[kO + k];
    s.d[k] = a[kD + k];
    s.radiance[k] = a[kRadiance + k];
  }
  s.t = a[kT];
  s.hit = hit.data();
  s.pdf = a[kPdf];
  a.fill(kT, std::numeric_limits<float>::infinity());
  if (finite)
    f.intersect(&s);
  else
    std::fill(hit.begin(), hit.end(), 1u);
  f.evaluate(&s);
  for (uint32_t i = 0; i < a.count(); ++i)
    if (hit[i] == 0)
      for (uint32_t r = kRadiance; r < kRows; ++r) a[r][i] = 0;
}

void LightEmissions::run(const LightFunctions& f, const void* light) {
  auto s = argumentsOf<LightEmitArgs>(a, kO, kTime, &light);
  for (uint32_t k = 0; k < 4; ++k) s.u[k] = a[kU + k];
  for (uint32_t k = 0; k < 3; ++k) {
    s.o[k] = a[kO + k];
    s.d[k] = a[kD + k];
    s.N[k] = a[kN + k];
    s.radiance[k] = a[kRadiance + k];
  }
  s.pdfPosition = a[kPdfPosition];
  s.pdfDirection = a[kPdfDirection];
  f.emit(&s);
}

}  // namespace kinora::testing
