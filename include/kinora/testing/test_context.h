// A shading context made by hand: points, directions and parameter settings without a scene, for tests of bxdfs and
// patterns. Called by the checks and by plug-in authors' own tests. It traces nothing and loads no texture.
#pragma once
#include <kinora/bxdf.h>
#include <kinora/context.h>
#include <kinora/testing/setting.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace kinora::testing {

struct Vec3 {
  float x = 0, y = 0, z = 0;
};

// Input of a context. Each array holds one entry (for all points) or one a point.
struct TestPoints {
  std::vector<Vec3> P{{0, 0, 0}};
  std::vector<Vec3> N{{0, 0, 1}};
  std::vector<Vec3> Ng;  // empty: as N
  std::vector<Vec3> wo{{0, 0, 1}};
  std::vector<Vec3> tangent;              // dPdu; empty: some unit vector perpendicular to N
  std::vector<Vec3> bitangent;            // dPdv; empty: N x tangent
  std::vector<Vec3> uv{{0.5f, 0.5f, 0}};  // u, v; texture coordinates alike
  std::vector<float> radius{0.01f}, time{0}, outerIor{1};
  std::vector<uint8_t> entering{1};
  uint32_t count() const;  // the longest array's length
};

enum class Slots {
  One,     // all lobes in one slot
  PerLobe  // each lobe its own; beyond kMaxSlots, reflecting lobes share slots 0..3 and transmitting ones 4..7
};

struct TestContextOptions {
  uint32_t width = 1;
  Slots slots = Slots::PerLobe;
  uint32_t traits = kTraitEyePath | kTraitPrimaryHit;
  bool varying = false;  // connectable parameters that the setting gives arrive as one value a point
};

// Textures of a test: rgba at (s, t).
using TestTexture = std::function<void(float s, float t, float radius, float rgba[4])>;

class TestContext {
 public:
  TestContext(const Descriptor& plugin, const Setting& setting, const TestPoints& points,
              const TestContextOptions& options = {});
  ~TestContext();
  TestContext(const TestContext&) = delete;
  TestContext& operator=(const TestContext&) = delete;

  // One value for all points, or one a point (values.size() = components * count, point-major).
  void setPrimvar(const std::string& name, uint32_t components, const std::vector<float>& values, float radius = 0);
  void setBuiltin(Builtin which, uint32_t components, const std::vector<float>& values);
  void setParameter(const std::string& name, const std::vector<float>& values);  // varying, as if connected
  void setManifold(const std::string& name, const Manifold& manifold);           // of a struct parameter
  void setTexture(TestTexture texture);                                          // without: missingColor

  const Context& context() const { return context_; }
  // Binds a bxdf's closure (BxdfFunctions::begin). The functions must be those of the context's width.
  void bind(const BxdfFunctions& functions);
  // n padded floats that live as long as the context, filled with NaN so that what is not written shows.
  float* floats(uint32_t n) const;
  uint32_t* words(uint32_t n) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  Context context_{};
};

}  // namespace kinora::testing
