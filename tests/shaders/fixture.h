// A folder of shaders and a square that shows what a network feeds to emitColor. Used by the tests of this folder.
#pragma once
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>

#include "support/render_scene.h"

namespace kinora::tests {

class Shaders : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (std::filesystem::temp_directory_path() / "kinora_shaders_XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ + "/" + name) << text; }
  // A square that fills the picture and shows emitColor, 16 x 16 pixels; `network` is everything before the geometry.
  RenderRequest requestOf(const std::string& network, const std::string& primvars = "") {
    RenderRequest r;
    r.rib = R"(Format 16 16 1
Hider "raytrace" "int maxsamples" [1]
PixelFilter "box" 1 1
Projection "orthographic"
WorldBegin
Light "PxrDomeLight" "sky"
Translate 0 0 1
)" + network +
            R"(Polygon "P" [-1 -1 0  -1 1 0  1 1 0  1 -1 0] "st" [0 0  0 1  1 1  1 0] )" + primvars + "\nWorldEnd\n";
    r.settings.shaderPath = {folder_};
    return r;
  }
  std::vector<int64_t> filmOf(const std::string& network, const std::string& primvars = "") {
    SceneRender render(requestOf(network, primvars));
    EXPECT_TRUE(render.messages().empty()) << render.messages()[0];
    return render.ok() ? stateOf(render.film()) : std::vector<int64_t>();
  }
  // Two materials, each with primvars of its own: a square over the left half of the picture in front of the whole one.
  RenderRequest halvesOf(const std::string& left, const std::string& leftPrimvars, const std::string& right,
                         const std::string& rightPrimvars) {
    return requestOf("AttributeBegin\n" + left + "Polygon \"P\" [-1 -1 0  -1 1 0  0 1 0  0 -1 0] " + leftPrimvars +
                         "\nAttributeEnd\nTranslate 0 0 .5\n" + right,
                     rightPrimvars);
  }
  static std::array<float, 3> at(SceneRender& render, int x) {
    const image::Image picture = render.channel("Ci");
    const float* p = picture.at(x, 8);
    return {p[0], p[1], p[2]};
  }
  std::array<float, 3> middleOf(SceneRender& render) { return at(render, 8); }
  // Lines of a code among those that a render gave.
  static size_t told(const SceneRender& render, const std::string& code) {
    size_t n = 0;
    for (const auto* lines : {&render.messages(), &render.infos()})
      for (const std::string& m : *lines) n += m.find(code + ":") != std::string::npos;
    return n;
  }
  std::string folder_;
};

inline constexpr const char* kShow = "Bxdf \"PxrConstant\" \"m\" \"reference color emitColor\" [\"n:result\"]\n";

}  // namespace kinora::tests
