// Proves: what the scene says to a pattern that nobody has is what its colours show: the colour named after the
// output, else the image, else its first colour, and what is connected to that. Misses: displacement and numbers,
// which have their defaults.
#include "fixture.h"
#include "image/read_write.h"

namespace kinora::tests {
namespace {

class MissingPatterns : public Shaders {
 protected:
  std::array<float, 3> shown(const std::string& patterns, const std::string& output, const std::string& said) {
    SceneRender render(
        requestOf(patterns + "Bxdf \"PxrConstant\" \"m\" \"reference color emitColor\" [\"n:" + output + "\"]\n"));
    EXPECT_TRUE(render.ok());
    EXPECT_GE(told(render, "PLUGIN-MISSING"), 1u) << patterns;
    const std::string first = render.messages().empty() ? std::string() : render.messages()[0];
    EXPECT_NE(first.find(said), std::string::npos) << first;
    return render.ok() ? middleOf(render) : std::array<float, 3>{};
  }
};
using Rgb = std::array<float, 3>;

TEST_F(MissingPatterns, ColourNamedAfterTheOutputStandsInThenTheFirst) {
  const std::string both = "Pattern \"nobody\" \"n\" \"color dirt\" [1 0 0] \"color cIn\" [.25 .5 .75]\n";
  EXPECT_EQ(shown(both, "Cout", "its cIn"), (Rgb{.25f, .5f, .75f}));
  EXPECT_EQ(shown(both, "resultRGB", "its cIn"), (Rgb{1, 0, 0}));
  EXPECT_EQ(
      shown("Pattern \"PxrOSL\" \"n\" \"string shader\" [\"nobody\"] \"color dirt\" [1 0 .5]\n", "Cout", "its dirt"),
      (Rgb{1, 0, .5f}));
}

TEST_F(MissingPatterns, WhatFeedsTheColourIsHandedOn) {
  const std::string lit = "Pattern \"PxrExposure\" \"e\" \"color inputRGB\" [.125 .25 .5] \"float stops\" [1]\n";
  EXPECT_EQ(shown(lit + "Pattern \"a\" \"m\" \"reference color Cin\" [\"e:resultRGB\"]\n" +
                      "Pattern \"b\" \"n\" \"reference color Cin\" [\"m:Cout\"]\n",
                  "Cout", "its Cin"),
            (Rgb{.25f, .5f, 1}));
  // through a missing pattern into one that is there
  EXPECT_EQ(shown("Pattern \"a\" \"m\" \"color Cin\" [.125 .25 .5]\n"
                  "Pattern \"PxrExposure\" \"n\" \"reference color inputRGB\" [\"m:Cout\"] \"float stops\" [1]\n",
                  "resultRGB", "its Cin"),
            (Rgb{.25f, .5f, 1}));
}

TEST_F(MissingPatterns, ImagesStandInWhereNoColourHasTheOutputsName) {
  constexpr auto kStored = image::StoredType::Float;
  image::Image picture({0, 0, 4, 4}, {{"R", kStored}, {"G", kStored}, {"B", kStored}});
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x)
      for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = 0.25f * float(c + 1);
  const std::string file = folder_ + "/wall.exr";
  ASSERT_TRUE(image::write(file, picture).ok());
  const std::string name = "\"string TextureName\" [\"" + file + "\"]";
  const auto near = [](const Rgb& a, const Rgb& b) {
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 1e-3);
  };
  near(shown("Pattern \"nobody\" \"n\" " + name + "\n", "Cout", "wall.exr"), {.25f, .5f, .75f});
  near(shown("Pattern \"nobody\" \"n\" \"color dirt\" [1 0 0] " + name + "\n", "Cout", "wall.exr"),
       {.25f, .5f, .75f});
  near(shown("Pattern \"nobody\" \"n\" \"color Cin\" [1 0 0] " + name + "\n", "Cout", "its Cin"), {1, 0, 0});
}

TEST_F(MissingPatterns, NothingToStandInLeavesDefaultsAndNothingHangs) {
  const Rgb standard = [&] {
    SceneRender render(requestOf("Bxdf \"PxrConstant\" \"m\"\n"));
    return middleOf(render);
  }();
  EXPECT_EQ(shown("Pattern \"nobody\" \"n\" \"float size\" [3]\n", "Cout", "uses its defaults"), standard);
  // one that is fed by itself
  EXPECT_EQ(shown("Pattern \"a\" \"n\" \"reference color Cin\" [\"n:Cout\"]\n", "Cout", ""), standard);
}

}  // namespace
}  // namespace kinora::tests
