// Materials that differ in numbers alone are shaded together, by one program whose parameters are gathered by point. None
// may see the others': every pattern and bxdf with each of its parameters changed, beside all the others and alone.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "plugin/registry.h"
#include "support/render_scene.h"

namespace kinora::tests {
namespace {

constexpr int kSide = 2;  // pixels of a material

std::string numbers(std::initializer_list<float> values) {
  std::string out = "[";
  for (const float v : values) out += std::to_string(v) + " ";
  return out + "]";
}

// A parameter with another value than its own; "": it has no numbers, or is part of the program.
std::string changed(const Param& p) {
  if (p.flags & (kParamOutput | kParamFixed | kParamArray | kParamFile)) return "";
  const float low = p.low, span = p.high - p.low;
  float one = low + 0.37f * span;
  if (std::fabs(one - p.value[0]) < 1e-3f * span) one = low + 0.61f * span;
  switch (p.type) {
    case Type::Float:
      return "\"float " + std::string(p.name) + "\" " + numbers({one});
    case Type::Color:
      return "\"color " + std::string(p.name) + "\" " + numbers({low + 0.8f * span, one, low + 0.2f * span});
    case Type::Vector:
    case Type::Point:
    case Type::Normal: {
      const char* const type = p.type == Type::Vector ? "vector" : p.type == Type::Point ? "point" : "normal";
      return "\"" + std::string(type) + " " + p.name + "\" " + numbers({0.3f, -0.2f, -0.9f});
    }
    default:
      return "";
  }
}

// Quads side by side, each with a material; `only` below 0: all of them.
image::Image shown(const std::vector<std::string>& materials, int only, const std::string& lights) {
  const int n = int(materials.size());
  RenderRequest r;
  r.rib = "Format " + std::to_string(kSide * n) + " " + std::to_string(kSide) +
          " 1\nProjection \"orthographic\"\nScreenWindow 0 " + std::to_string(n) +
          " -0.5 0.5\nHider \"raytrace\" \"int maxsamples\" [1] \"int minsamples\" [1]\nPixelFilter \"box\" 1 1\n"
          "Integrator \"PxrPathTracer\" \"i\" \"int maxIndirectBounces\" [1]\nWorldBegin\n" +
          lights;
  for (int i = 0; i < n; ++i) {
    if (only >= 0 && i != only) continue;
    const std::string left = std::to_string(i), right = std::to_string(i + 1);
    r.rib += "AttributeBegin\n" + materials[size_t(i)] + "Polygon \"P\" [" + left + " -0.5 1 " + right + " -0.5 1 " +
             right + " 0.5 1.2 " + left + " 0.5 1.2] \"st\" [0.1 0.1 0.9 0.2 0.8 0.9 0.2 0.8]\nAttributeEnd\n";
  }
  r.rib += "WorldEnd\n";
  SceneRender render(r);
  return render.ok() ? render.channel("Ci") : image::Image();
}

void compare(const std::string& plugin, const std::vector<std::string>& names,
             const std::vector<std::string>& materials, const std::string& lights) {
  const image::Image together = shown(materials, -1, lights);
  ASSERT_FALSE(together.pixels.empty()) << plugin;
  for (int i = 0; i < int(materials.size()); ++i) {
    const image::Image alone = shown(materials, i, lights);
    ASSERT_FALSE(alone.pixels.empty()) << plugin;
    double most = 0;
    for (int y = 0; y < kSide; ++y)
      for (int x = kSide * i; x < kSide * (i + 1); ++x)
        for (int k = 0; k < 3; ++k) {
          const double a = alone.at(x, y)[k], b = together.at(x, y)[k];
          most = std::max(most, std::fabs(a - b) / (1e-3 + std::fabs(a)));
        }
    EXPECT_LT(most, 2e-3) << plugin << " with another " << names[size_t(i)] << "\n" << materials[size_t(i)];
  }
}

TEST(SharedPrograms, PatternsKeepTheirOwnNumbers) {
  for (const Descriptor* d : Registry().all(Kind::Pattern)) {
    const std::string name = d->name;
    std::string output;
    for (uint32_t p = 0; p < d->paramCount && output.empty(); ++p)
      if (d->params[p].flags & kParamOutput && d->params[p].type != Type::Struct) output = d->params[p].name;
    if (output.empty()) continue;
    std::vector<std::string> names{"nothing"}, materials;
    const auto material = [&](const std::string& params) {
      const std::string handle = "p" + std::to_string(materials.size());
      materials.push_back("Pattern \"" + name + "\" \"" + handle + "\" " + params +
                          "\nBxdf \"PxrConstant\" \"c\" \"reference color emitColor\" [\"" + handle + ":" + output +
                          "\"]\n");
    };
    material("");
    for (uint32_t p = 0; p < d->paramCount; ++p)
      if (const std::string text = changed(d->params[p]); !text.empty()) {
        names.push_back(d->params[p].name);
        material(text);
      }
    compare(name, names, materials, "");
  }
}

TEST(SharedPrograms, MaterialsKeepTheirOwnNumbers) {
  const std::string lights =
      "AttributeBegin Rotate 40 1 1 0 Light \"PxrDistantLight\" \"l\" AttributeEnd\n"
      "Light \"PxrDomeLight\" \"d\" \"float intensity\" [0.3]\n";
  for (const Descriptor* d : Registry().all(Kind::Bxdf)) {
    const std::string name = d->name;
    if (name == "PxrVolume") continue;  // a medium's neighbours are around its points
    std::vector<std::string> names{"nothing"}, materials{"Bxdf \"" + name + "\" \"b\"\n"};
    for (uint32_t p = 0; p < d->paramCount; ++p)
      if (const std::string text = changed(d->params[p]); !text.empty()) {
        names.push_back(d->params[p].name);
        materials.push_back("Bxdf \"" + name + "\" \"b\" " + text + "\n");
      }
    compare(name, names, materials, lights);
  }
}

}  // namespace
}  // namespace kinora::tests
