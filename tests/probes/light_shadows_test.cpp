// Lights that say what their shadows are, and lights behind filters that depend on the lit point: PxrVCM with every set
// of techniques against the path tracer. Light paths would carry such light where it does not belong. Equal bits for
// threads, widths, groups and splits.
#include <string>

#include "tests/probes/methods.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

// A lamp with the parameters given instead of the plain one.
std::string with(std::string lamp, const std::string& name, const std::string& parameters) {
  const std::string handle = "\"" + name + "\"";
  lamp.insert(lamp.find(handle) + handle.size(), " " + parameters);
  return lamp;
}
std::string controlledLamps() {
  return with(kRect, "lamp",
              "\"color shadowColor\" [0.3 0.1 0.2] \"float shadowDistance\" [0.8] \"float shadowFalloff\" [0.5]") +
         with(kSphere, "bulb", "\"string shadowExcludeSubset\" [\"balls\"]") +
         with(kSun, "sun", "\"float shadowDistance\" [0.3]");
}
std::string member(const char* bxdf) {
  return std::string("Attribute \"grouping\" \"string membership\" [\"balls\"]\n") + bxdf;
}

TEST(LightShadows, VcmEqualsThePathTracer) { expectSamePicture(room(controlledLamps(), member(kGrey)), 0.04); }
TEST(LightShadows, SameBits) {
  for (const char* integrator : {"PxrPathTracer", "PxrVCM"})
    expectSameBits({}, room(controlledLamps(), member(kGlass)), integrator);
}
TEST(LightShadows, VcmEqualsThePathTracerBehindFilters) {
  const std::string filter = R"(
    AttributeBegin
      LightFilter "PxrRodLightFilter" "rod" "float width" [0.8] "float height" [0.8] "float depth" [0.8]
        "float edge" [0.3] "float intensity" [0.1]
)";
  std::string lamp = kRect;
  lamp.replace(lamp.find("AttributeBegin"), 14, filter.substr(filter.find("AttributeBegin")));
  expectSamePicture(room(lamp + kPoint, kGrey), 0.04);
}

TEST(LightShadows, VcmEqualsThePathTracerWithoutShadows) {
  expectSamePicture(room(with(kSphere, "bulb", "\"int enableShadows\" [0]") + kRect, kGrey), 0.04);
}

// Of which the glossy floor gets its part alone.
TEST(LightShadows, VcmEqualsThePathTracerBehindFiltersOfDiffuseLight) {
  std::string lamp = kRect;
  const std::string begin = "AttributeBegin";
  lamp.replace(lamp.find(begin), begin.size(), R"(AttributeBegin
      LightFilter "PxrIntMultLightFilter" "tint" "color tint" [0.2 0.6 1] "float diffuse" [0.9] "float specular" [0.1]
)");
  expectSamePicture(room(lamp + kPoint, kGrey), 0.04);
}

}  // namespace
}  // namespace kinora::probes
