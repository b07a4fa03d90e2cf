// RIB text that the tests of truth share: cameras that look along +z from the origin, integrators without bias.
#pragma once
#include <kinora/plugin.h>
#include <kinora/testing/setting.h>

#include <string>
#include <string_view>

namespace kinora::tests {

// Path tracing with every deliberate bias off.
inline std::string unbiased(int bounces, const std::string& more = "") {
  return "Integrator \"PxrPathTracer\" \"i\" \"int maxIndirectBounces\" [" + std::to_string(bounces) +
         "] \"float clampLuminance\" [1e30] \"float rouletteThreshold\" [0] \"int allowCaustics\" [1] " + more + "\n";
}
// `half`: half the side of the square that parallel rays cover.
inline std::string orthographic(int pixels, double half, int samples) {
  const std::string n = std::to_string(pixels), h = std::to_string(half);
  return "Format " + n + " " + n + " 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [" +
         std::to_string(samples) + "]\nScreenWindow -" + h + " " + h + " -" + h + " " + h +
         "\nProjection \"orthographic\"\n";
}

// A setting of the testing kit ("name=v v v; name=v") as RIB parameters.
inline std::string asRib(const Descriptor& d, std::string_view setting) {
  constexpr std::pair<Type, const char*> kTypes[] = {{Type::Int, "int"},
                                                     {Type::Color, "color"},
                                                     {Type::Vector, "vector"},
                                                     {Type::Normal, "normal"},
                                                     {Type::String, "string"}};
  std::string out;
  while (!setting.empty()) {
    const size_t end = setting.find(';');
    std::string_view pair = setting.substr(0, end);
    setting = end == std::string_view::npos ? std::string_view() : setting.substr(end + 1);
    const size_t first = pair.find_first_not_of(' '), equals = pair.find('=');
    if (first == std::string_view::npos || equals == std::string_view::npos) continue;
    const std::string name(pair.substr(first, equals - first));
    const char* type = "float";
    for (uint32_t i = 0; i < d.paramCount; ++i)
      for (const auto& [is, named] : kTypes)
        if (name == d.params[i].name && d.params[i].type == is) type = named;
    const std::string value(pair.substr(equals + 1)), quote = std::string_view(type) == "string" ? "\"" : "";
    out += " \"" + std::string(type) + " " + name + "\" [" + quote + value + quote + "]";
  }
  return out;
}

}  // namespace kinora::tests
