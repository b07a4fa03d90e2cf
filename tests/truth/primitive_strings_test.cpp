// Proves: a texture's name with <primstr:NAME> is each object's own file, for objects that share a mesh and for objects of
// an instance, and an object without the word is told. Misses: displacements, whose names are not completed.
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>

#include "image/read_write.h"
#include "support/render_scene.h"

namespace kinora::tests {
namespace {

TEST(PrimitiveStrings, EachObjectHasItsOwnTexture) {
  const std::string folder = ::testing::TempDir() + "kinora_primstr";
  std::filesystem::create_directories(folder);
  for (const bool isRed : {true, false}) {
    image::Image one({0, 0, 4, 4}, {{"R"}, {"G"}, {"B"}});
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 4; ++x)
        for (int c = 0; c < 3; ++c) one.at(x, y)[c] = c == (isRed ? 0 : 2) ? 0.5f : 0.f;
    ASSERT_TRUE(image::write(folder + "/wall_" + (isRed ? "red" : "blue") + "_v1.exr", one).ok());
  }
  const std::string material = "Pattern \"PxrTexture\" \"t\" \"string filename\" [\"" + folder +
                               "/wall_<primstr:look>_<primstr:version>.exr\"] \"int linearize\" [0]\n"
                               "Bxdf \"PxrConstant\" \"c\" \"reference color emitColor\" [\"t:resultRGB\"]\n";
  const auto words = [](const char* look) {
    return std::string(" \"constant string look\" [\"") + look + "\"] \"constant string version\" [\"v1\"]\n";
  };
  const auto ball = [&](double x, const char* look) {
    return "AttributeBegin\nTranslate " + std::to_string(x) + " 0 5\nSphere 0.9 -0.9 0.9 360" + words(look) +
           "AttributeEnd\n";
  };
  const auto render = [&](const std::string& objects) {
    RenderRequest r;
    r.rib =
        "Format 16 8 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [4]\nScreenWindow -2 2 -1 1\n"
        "Projection \"orthographic\"\nWorldBegin\n" +
        material + objects + "WorldEnd\n";
    return std::make_unique<SceneRender>(r);
  };
  for (const std::string& objects :
       {ball(-1, "red") + ball(1, "blue"),
        "ObjectBegin \"o\"\n" + ball(-1, "red") + ball(1, "blue") + "ObjectEnd\nObjectInstance \"o\"\n"}) {
    const auto s = render(objects);
    ASSERT_TRUE(s->ok());
    EXPECT_TRUE(s->messages().empty() || s->messages()[0].find("RENDER-NO-LIGHTS") != std::string::npos)
        << s->messages()[0];
    const image::Image picture = s->channel("Ci");
    EXPECT_NEAR(picture.at(4, 4)[0], 0.5, 1e-3);
    EXPECT_NEAR(picture.at(4, 4)[2], 0, 1e-3);
    EXPECT_NEAR(picture.at(12, 4)[0], 0, 1e-3);
    EXPECT_NEAR(picture.at(12, 4)[2], 0.5, 1e-3);
  }
  const auto without = render("Translate 0 0 5\nSphere 1 -1 1 360\n");
  std::string all;
  for (const std::string& m : without->messages()) all += m + "\n";
  EXPECT_NE(all.find("PATTERN-PRIMSTR"), std::string::npos) << all;
  EXPECT_NE(all.find("<primstr:look>"), std::string::npos) << all;
}

}  // namespace
}  // namespace kinora::tests
