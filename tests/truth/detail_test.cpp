// Proves: of objects with a range of detail that one is drawn whose range holds the size of its box on screen, in
// pixels of area times RelativeDetail; also inside objects, by the place of each instance, around instances, and after
// the camera was edited; what is wrong is a message. Misses: transitions, which are cuts at their middle.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/render_scene.h"

namespace kinora::tests {
namespace {

std::string glow(const std::string& rgb) { return "Bxdf \"PxrConstant\" \"c\" \"color emitColor\" [" + rgb + "]\n"; }
const std::string kSquare = "Patch \"bilinear\" \"P\" [-.5 .5 0  .5 .5 0  -.5 -.5 0  .5 -.5 0]\n";
// Red up to 4 pixels of area, green up to 40, blue beyond.
const std::string kLevels = "AttributeBegin\nDetail [-.5 .5 -.5 .5 -.5 .5]\nDetailRange 0 0 3 5\n" + glow("1 0 0") +
                            kSquare + "DetailRange [3 5 40 40]\n" + glow("0 1 0") + kSquare +
                            "DetailRange 40 40 1e38 1e38\n" + glow("0 0 1") + kSquare + "AttributeEnd\n";

// The colour in the middle of the picture: r, g or b; '-': none.
char seen(const std::string& world, double pixels, const std::string& options = "",
          std::vector<std::string>* messages = nullptr, std::function<void(scene::Scene&)> edit = {}) {
  const std::string w = std::to_string(4 / pixels);
  RenderRequest r;
  r.rib =
      "Format 8 8 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [64] \"int minsamples\" [64]\n"
      "Projection \"orthographic\"\nScreenWindow -" +
      w + " " + w + " -" + w + " " + w + "\n" + options +
      "WorldBegin\nPolygon \"P\" [9 9 9 9.1 9 9 9 9.1 9]\nTranslate 0 0 2\n" + world + "WorldEnd\n";
  r.edit = std::move(edit);
  SceneRender s(r);
  EXPECT_TRUE(s.ok()) << world;
  if (!s.ok()) return '?';
  if (messages) *messages = s.messages();
  const image::Image picture = s.channel("Ci");
  for (int c = 0; c < 3; ++c)
    if (picture.at(3, 4)[size_t(c)] > .5f || picture.at(4, 4)[size_t(c)] > .5f) return "rgb"[c];
  return '-';
}

TEST(Detail, FollowsTheSizeOnScreen) {
  EXPECT_EQ(seen(kLevels, 1.8), 'r');
  EXPECT_EQ(seen(kLevels, 2.1), 'g') << "the middle of the transition is 4";
  EXPECT_EQ(seen(kLevels, 6), 'g');
  EXPECT_EQ(seen(kLevels, 6.5), 'b');
  EXPECT_EQ(seen("Scale 2 2 2\n" + kLevels, 3.5), 'b');
  EXPECT_EQ(seen(kLevels, 6.5, "RelativeDetail .5\n"), 'g');
  EXPECT_EQ(seen("DetailRange 0 0 3 5\n" + glow("1 0 0") + kSquare + "DetailRange 3 5 1e38 1e38\n" + glow("0 0 1") +
                     kSquare,
                 2),
            'b')
      << "without a box there is all the detail";
}

TEST(Detail, IsThatOfEachInstance) {
  const std::string object = "ObjectBegin \"o\"\n" + kLevels + "ObjectEnd\n";
  for (int twice = 0; twice < 2; ++twice) {
    // the first instance is another size, and beside the picture
    const std::string first = "TransformBegin\nTranslate 30 0 0\nScale 3 3 3\nObjectInstance \"o\"\nTransformEnd\n";
    const auto placed = [&](const std::string& scale) {
      return object + (twice ? first : "") + "Scale " + scale + "\nObjectInstance \"o\"\n";
    };
    EXPECT_EQ(seen(placed("1 1 1"), 1.5), 'r');
    EXPECT_EQ(seen(placed("2 2 2"), 1.5), 'g');
    EXPECT_EQ(seen(placed("6 6 6"), 1.5), 'b');
  }
  const auto around = [&](const std::string& range) {
    return "ObjectBegin \"s\"\n" + kSquare +
           "ObjectEnd\nObjectBegin \"t\"\nDetail [-.5 .5 -.5 .5 0 0]\nDetailRange " + range +
           "\nObjectInstance \"s\"\nObjectEnd\n" + glow("0 1 0") + "ObjectInstance \"t\"\n";
  };
  EXPECT_EQ(seen(around("0 0 10 10"), 4), '-');
  EXPECT_EQ(seen(around("10 10 20 20"), 4), 'g');
}

TEST(Detail, FollowsAnEditedCamera) {
  RenderRequest r;
  const auto zoomed = [](scene::Scene& s) { s.cameras[0].screenWindow = {-.5f, .5f, -.5f, .5f}; };
  EXPECT_EQ(seen(kLevels, 1.5, "", nullptr, zoomed), 'b');
  Registry registry;
  Diagnostics silent([](const std::string&, Severity) {});
  r.rib = "Format 8 8 1\nProjection \"orthographic\"\nScreenWindow -4 4 -4 4\nWorldBegin\nTranslate 0 0 2\n" +
          kLevels + "WorldEnd\n";
  SceneRender s(r);
  ASSERT_TRUE(s.ok());
  const uint64_t before = hashOf(s.film());
  s.renderer().scene().cameras[0].screenWindow = {-.5f, .5f, -.5f, .5f};
  ASSERT_TRUE(s.renderer().update());
  ASSERT_EQ(s.renderer().renderFilm(), render::Outcome::Complete);
  EXPECT_NE(hashOf(s.film()), before);
  EXPECT_GT(s.channel("Ci").at(4, 4)[2], .5f);
}

bool isTold(const std::vector<std::string>& messages, const std::string& what) {
  return std::any_of(messages.begin(), messages.end(),
                     [&](const std::string& m) { return m.find(what) != std::string::npos; });
}

TEST(Detail, BadInputIsTold) {
  const struct {
    const char* text;
    char expected;
  } table[] = {{"Detail [0 1 0 1 0]\n", 'g'},
               {"DetailRange 4 3 2 1\n", 'g'},
               {"DetailRange 0 1\n", 'g'},
               {"Attribute \"detail\" \"float[2] range\" [5 6]\n", 'g'}};
  for (const auto& row : table) {
    std::vector<std::string> messages;
    EXPECT_EQ(seen(row.text + glow("0 1 0") + kSquare, 4, "", &messages), row.expected) << row.text;
    if (row.text[0] == 'D') {
      EXPECT_TRUE(isTold(messages, "Detail")) << row.text;
    }
  }
  std::vector<std::string> messages;
  seen(kSquare, 4, "RelativeDetail -1\n", &messages);
  EXPECT_TRUE(isTold(messages, "RelativeDetail"));
}

}  // namespace
}  // namespace kinora::tests
