// Colours by an OpenColorIO configuration and without one: the working space, textures by file rules and by type,
// views, and configurations that are missing or broken. Misses: OpenColorIO's own arithmetic.
#include "image/colors.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace kinora::image {
namespace {

constexpr const char* kConfig = R"(ocio_profile_version: 2
search_path: ""
strictparsing: true
roles:
  default: lin
  scene_linear: lin
file_rules:
  - !<Rule> {name: Half, colorspace: half, pattern: "*_half", extension: png}
  - !<Rule> {name: Default, colorspace: default}
displays:
  screen:
    - !<View> {name: Twice, colorspace: twice}
    - !<View> {name: Plain, colorspace: lin}
active_displays: []
active_views: []
colorspaces:
  - !<ColorSpace>
    name: lin
    isdata: false
  - !<ColorSpace>
    name: half
    to_scene_reference: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: twice
    from_scene_reference: !<MatrixTransform> {matrix: [2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1]}
  - !<ColorSpace>
    name: sRGB
    to_scene_reference: !<ExponentTransform> {value: 2}
)";

class Configured : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("kinora-colors-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string write(const std::string& text) const {
    std::ofstream(folder_ / "config.ocio") << text;
    return (folder_ / "config.ocio").string();
  }
  std::filesystem::path folder_;
};

TEST_F(Configured, SaysTheWorkingSpaceAndThatOfTextures) {
  const Colors c(write(kConfig));
  ASSERT_EQ(c.problem(), "");
  EXPECT_TRUE(c.isManaged());
  EXPECT_EQ(c.workingSpace(), "lin");
  EXPECT_EQ(c.spaceOf("/x/wood_half.png", true), "half");
  EXPECT_EQ(c.spaceOf("/x/wood.png", true), "sRGB");
  EXPECT_EQ(c.spaceOf("/x/wood.exr", false), "lin");
  float pixels[8] = {0.5f, 0.25f, 1, 0.5f, 1, 1, 1, 0.25f};
  ASSERT_TRUE(c.toWorking("wood.png", true, pixels, 2, 4, 3));
  EXPECT_NEAR(pixels[0], 0.25f, 1e-5f);
  EXPECT_NEAR(pixels[1], 0.0625f, 1e-5f);
  EXPECT_EQ(pixels[3], 0.5f) << "alpha is no colour";
  float grey[2] = {0.5f, 1.f};
  ASSERT_TRUE(c.toWorking("a_half.png", true, grey, 2, 1, -1));
  EXPECT_NEAR(grey[0], 0.25f, 1e-6f);
}

TEST_F(Configured, ViewsAreFoundByNameAndApplied) {
  const Colors c(write(kConfig));
  EXPECT_EQ(c.findView("default"), "screen/Twice");
  EXPECT_EQ(c.findView("Plain"), "screen/Plain");
  EXPECT_EQ(c.findView("screen/Plain"), "screen/Plain");
  EXPECT_EQ(c.findView("Filmic"), "");
  float rgba[8] = {0.25f, 0.125f, 0, 1, 0.5f, 0.5f, 0.5f, 0.5f};
  ASSERT_TRUE(c.toView("screen/Twice", rgba, 2, 4));
  EXPECT_NEAR(rgba[0], 0.5f, 1e-6f);
  EXPECT_EQ(rgba[3], 1.f);
  EXPECT_NEAR(rgba[4], 1.f, 1e-6f);
}

TEST_F(Configured, MissingAndBrokenConfigurationsLeaveTheBuiltInColours) {
  std::string broken(kConfig, 300);
  broken += "\n  - !<Rule> {{{";
  std::string withoutRole = kConfig;
  withoutRole.replace(withoutRole.find("  scene_linear: lin\n"), 20, "");
  for (const std::string& file : {std::string("/no/such/config.ocio"), write(broken)}) {
    const Colors c(file);
    EXPECT_FALSE(c.isManaged());
    EXPECT_NE(c.problem().find(file), std::string::npos) << c.problem();
    EXPECT_EQ(c.workingSpace(), Colors("").workingSpace());
    EXPECT_EQ(c.spaceOf("a.png", true), "");
    float p[3] = {0.5f, 0.5f, 0.5f};
    EXPECT_FALSE(c.toWorking("a.png", true, p, 1, 3, -1));
    EXPECT_EQ(p[0], 0.5f);
    EXPECT_EQ(c.findView("default"), "");
  }
  EXPECT_FALSE(Colors(write(withoutRole)).isManaged());
  EXPECT_EQ(Colors("").problem(), "");
}

}  // namespace
}  // namespace kinora::image
