// Proves: what stands in an object takes its attributes from the object's own block, all others from each instance,
// and none from before ObjectBegin (RISpec 5.9); orientations by RISpec 4.2.14. One square in the middle of the
// picture, shown by what can be seen of it. Misses: attributes without an effect on pixels.
#include <gtest/gtest.h>

#include "support/render_scene.h"

namespace kinora::tests {
namespace {

const std::string kHead =
    "Format 8 8 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [16] \"int minsamples\" [16]\n"
    "Projection \"orthographic\"\nScreenWindow -1 1 -1 1\n";
// A patch that fills the picture and turns its front to the camera.
const std::string kPatch = "Patch \"bilinear\" \"P\" [-2 2 0  2 2 0  -2 -2 0  2 -2 0]\n";

// Mean of the first component of Ci, and of alpha.
struct Seen {
  double colour = 0, alpha = 0;
};
Seen seen(const std::string& world, const std::string& head = "") {
  RenderRequest r;
  r.rib = kHead + head + "WorldBegin\nTranslate 0 0 2\n" + world + "WorldEnd\n";
  SceneRender s(r);
  EXPECT_TRUE(s.ok()) << world;
  if (!s.ok()) return {};
  return {overPixels(s.channel("Ci")).mean(), overPixels(s.channel("a")).mean()};
}

std::string glow(double x) {
  const std::string v = std::to_string(x);
  return "Bxdf \"PxrConstant\" \"c\" \"color emitColor\" [" + v + " " + v + " " + v + "]\n";
}
std::string shows(const std::string& name, const std::string& type) {
  return "Pattern \"PxrPrimvar\" \"p\" \"string varname\" [\"" + name + "\"] \"string type\" [\"" + type +
         "\"]\nBxdf \"PxrConstant\" \"c\" \"reference color emitColor\" [\"p:resultRGB\"]\n";
}

TEST(Objects, AttributesOfTheBlockThenOfTheInstance) {
  // `one` and `other` are two settings of an attribute; `look` stands with the instance and shows it. What is seen of
  // both and of neither is asked of a plain square, so that the table holds no picture's numbers.
  const struct {
    const char* what;
    std::string look, one, other;
  } table[] = {
      {"Bxdf", "", glow(0.75), glow(0.25)},
      {"Color as Cs", shows("Cs", "color"), "Color [.6 .6 .6]\n", "Color [.2 .2 .2]\n"},
      {"Color of the plain material", "Light \"PxrDomeLight\" \"d\"\n", "Color [.6 .6 .6]\n", "Color [.2 .2 .2]\n"},
      {"Opacity as Os", shows("Os", "color"), "Opacity [.6 .6 .6]\n", "Opacity [.2 .2 .2]\n"},
      {"Sides", glow(1) + "Rotate 180 0 1 0\n", "Sides 1\n", "Sides 2\n"},
      {"Orientation", glow(1) + "Attribute \"Ri\" \"int Sides\" [1]\n", "Orientation \"inside\"\n",
       "Orientation \"outside\"\n"},
      {"Ri:Sides", glow(1) + "Rotate 180 0 1 0\n", "Attribute \"Ri\" \"int Sides\" [1]\n",
       "Attribute \"Ri\" \"int Sides\" [2]\n"},
      {"Ri:ReverseOrientation", glow(1) + "Sides 1\n", "Attribute \"Ri\" \"int ReverseOrientation\" [1]\n",
       "Attribute \"Ri\" \"int ReverseOrientation\" [0]\n"},
      {"visibility", glow(1), "Attribute \"visibility\" \"int camera\" [0]\n",
       "Attribute \"visibility\" \"int camera\" [1]\n"},
      {"Matte", glow(1), "Matte 1\n", "Matte 0\n"},
      {"holdout", glow(1), "Attribute \"trace\" \"int holdout\" [1]\n", "Attribute \"trace\" \"int holdout\" [0]\n"},
      {"TextureCoordinates", shows("st", "float2"), "TextureCoordinates 0 0 2 0 0 1 2 1\n",
       "TextureCoordinates 0 0 1 0 0 1 1 1\n"},
      {"light linking",
       "AttributeBegin\nAttribute \"grouping\" \"string membership\" [\"key\"]\nLight \"PxrDomeLight\" \"d\"\n"
       "AttributeEnd\nBxdf \"PxrDiffuse\" \"w\"\n",
       "Attribute \"lighting\" \"string excludesubset\" [\"key\"]\n",
       "Attribute \"lighting\" \"string excludesubset\" [\"\"]\n"},
  };
  for (const auto& row : table) {
    const auto plain = [&](const std::string& setting) { return seen(row.look + setting + kPatch); };
    const auto placed = [&](const std::string& before, const std::string& inside, const std::string& with) {
      return seen("AttributeBegin\n" + before + "ObjectBegin \"o\"\n" + inside + kPatch +
                  "ObjectEnd\nAttributeEnd\n" + row.look + with + "ObjectInstance \"o\"\n");
    };
    const Seen one = plain(row.one), other = plain(row.other), none = plain("");
    ASSERT_GT(std::abs(one.colour - other.colour) + std::abs(one.alpha - other.alpha), 0.05) << row.what;
    const auto expect = [&](const Seen& got, const Seen& wanted, const char* how) {
      EXPECT_NEAR(got.colour, wanted.colour, 2e-3) << row.what << ' ' << how;
      EXPECT_NEAR(got.alpha, wanted.alpha, 1e-4) << row.what << ' ' << how;
    };
    expect(placed(row.one, "", ""), none, "before ObjectBegin");
    expect(placed(row.other, "", row.one), one, "with the instance, another before");
    expect(placed("", "", row.other), other, "with the instance");
    expect(placed("", row.one, row.other), one, "in the block, another with the instance");
    expect(placed("", row.other, row.one), other, "in the block, the other way round");
    expect(placed("", row.one, ""), one, "in the block alone");
    // an object inside an object: the inner instance's, then the outer's
    const auto nested = [&](const std::string& inner, const std::string& outer) {
      return seen("ObjectBegin \"o\"\n" + kPatch + "ObjectEnd\nObjectBegin \"p\"\n" + inner +
                  "ObjectInstance \"o\"\nObjectEnd\n" + row.look + outer + "ObjectInstance \"p\"\n");
    };
    expect(nested("", row.one), one, "through two objects");
    expect(nested(row.one, row.other), one, "with the inner instance");
  }
}

TEST(Objects, InstancesOfOneObjectDiffer) {
  // Left and right half of the picture; one side each, turned by one instance only.
  const std::string object =
      "ObjectBegin \"o\"\nPatch \"bilinear\" \"P\" [-1 2 0  1 2 0  -1 -2 0  1 -2 0]\nObjectEnd\n";
  const auto half = [](double x, const std::string& attributes) {
    return "AttributeBegin\n" + attributes + "Translate " + std::to_string(x) +
           " 0 0\nObjectInstance \"o\"\nAttributeEnd\n";
  };
  const std::string sided = object + glow(1) + "Sides 1\n";
  EXPECT_NEAR(seen(sided + half(-1, "") + half(1, "")).alpha, 1, 1e-6);
  EXPECT_NEAR(seen(sided + half(-1, "") + half(1, "ReverseOrientation\n")).alpha, 0.5, 1e-6);
  EXPECT_NEAR(seen(sided + half(-1, "Sides 2\nReverseOrientation\n") + half(1, "ReverseOrientation\n")).alpha, 0.5,
              1e-6);
  EXPECT_NEAR(seen(sided + half(-1, glow(0.5)) + half(1, "")).colour, 0.75, 1e-6);
  // toggles of block and instance cancel
  const std::string turned = "ObjectBegin \"o\"\nReverseOrientation\n" + kPatch + "ObjectEnd\nSides 1\n" + glow(1);
  EXPECT_EQ(seen(turned + "ObjectInstance \"o\"\n").alpha, 0);
  EXPECT_EQ(seen(turned + "ReverseOrientation\nObjectInstance \"o\"\n").alpha, 1);
}

TEST(Objects, OrientationTurnsWithTheSpace) {
  // Seen from its front under Sides 1. The camera's space is left-handed; what mirrors the space takes the current
  // orientation along, so only mirrors before the request tell "lh" from "outside".
  const struct {
    std::string requests;
    double alpha;
  } table[] = {
      {"Orientation \"outside\"\n", 1},
      {"Orientation \"lh\"\n", 1},
      {"Orientation \"rh\"\n", 0},
      {"Orientation \"lh\"\nScale 1 1 -1\n", 1},
      {"Orientation \"rh\"\nScale 1 1 -1\n", 0},
      {"Scale 1 1 -1\nOrientation \"lh\"\n", 0},
      {"Scale 1 1 -1\nOrientation \"rh\"\n", 1},
      {"Scale 1 1 -1\nOrientation \"rh\"\nScale 1 1 -1\n", 1},
      {"Scale 1 1 -1\nOrientation \"outside\"\n", 1},
      {"ReverseOrientation\nOrientation \"outside\"\n", 1},
      {"Orientation \"rh\"\nReverseOrientation\n", 1},
      {"Scale 1 1 -1\nAttribute \"Ri\" \"string Orientation\" [\"lh\"]\n", 0},
  };
  // mirrored in z the patch lies in its own plane: what faced the camera faces away, and its outside with it
  const auto facing = [](const std::string& requests) {
    int mirrors = 0;
    for (size_t at = requests.find("Scale"); at != std::string::npos; at = requests.find("Scale", at + 1)) ++mirrors;
    return mirrors % 2 ? "Rotate 180 0 1 0\n" : "";
  };
  for (const auto& row : table)
    for (const bool instanced : {false, true}) {
      const std::string shape = instanced ? "ObjectBegin \"o\"\n" + kPatch + "ObjectEnd\n" : std::string();
      const std::string world = glow(1) + "Sides 1\n" + shape + row.requests + facing(row.requests) +
                                (instanced ? "ObjectInstance \"o\"\n" : kPatch);
      EXPECT_EQ(seen(world).alpha, row.alpha) << row.requests << (instanced ? "instanced" : "");
    }
  // a camera that mirrors the world: before it the same requests name camera space
  EXPECT_EQ(seen(glow(1) + "Sides 1\nOrientation \"lh\"\nRotate 180 0 1 0\n" + kPatch, "Scale -1 1 1\n").alpha, 1);
}

TEST(Objects, PrimvarsThatAreImplied) {
  // the plug-in's answers without any such primvar in the scene
  EXPECT_NEAR(seen(shows("st", "float2") + kPatch).colour, 0.5, 1e-3);
  EXPECT_NEAR(seen(shows("s", "float") + "TextureCoordinates 0 0 2 0 0 1 2 1\n" + kPatch).colour, 1, 1e-3);
  EXPECT_NEAR(seen(shows("Cs", "color") + "Color [.3 .4 .5]\n" + kPatch).colour, 0.3, 1e-6);
  EXPECT_NEAR(seen(shows("Os", "color") + "Opacity [.7 .4 .5]\n" + kPatch).colour, 0.7, 1e-6);
  // a primvar that is given wins
  const std::string own =
      "Patch \"bilinear\" \"P\" [-2 2 0  2 2 0  -2 -2 0  2 -2 0] \"constant color Cs\" [.9 .9 .9]\n";
  EXPECT_NEAR(seen(shows("Cs", "color") + "Color [.3 .4 .5]\n" + own).colour, 0.9, 1e-6);
}

// Instances that no ray can be brought into the space of are left out and told by name, file and line; what moves
// through such a moment is drawn. Embree ends the program on a ray with numbers beyond 1.8e18, and where a moment
// without volume falls onto a ray's time: the middle of the shutter does, as one in 16 million.
TEST(Objects, WithoutVolumeAreLeftOutAndTold) {
  const std::string object = "ObjectBegin \"thing\"\n" + kPatch + "Sphere .5 -.5 .5 360\nObjectEnd\n";
  const auto moving = [](const std::string& a, const std::string& b) {
    return "MotionBegin [0 1]\n" + a + b + "MotionEnd\n";
  };
  const struct {
    const char* what;
    std::string transform;
    bool isLost;
  } table[] = {
      {"flat", "Scale 1 1 1e-20\n", true},
      {"tiny", "Scale 1e-13 1e-13 1e-13\n", true},
      {"tiny twice", "Scale 1e-30 1e-30 1e-30\n", true},
      {"small and far", "Translate 1e10 0 0\nScale 1e-9 1e-9 1e-9\n", true},
      {"huge", "Scale 1e18 1e18 1e18\n", true},
      {"thin", "Scale 1 1 1e-9\n", false},
      {"flat throughout", moving("Scale 1 1 1e-20\n", "Scale 1 1 1e-25\n"), true},
      {"flat at the end", moving("Scale 1 1 1\n", "Scale 1 1 1e-20\n"), false},
      {"flat at the beginning", moving("Scale 1 1 1e-30\n", "Scale 1 1 1\n"), false},
      {"inside out", moving("Scale 1 1 1\n", "Scale 1 1 -1\n"), false},
      {"half a turn", moving("Rotate 0 0 0 1\n", "Rotate 180 0 0 1\n"), false},
  };
  for (const auto& row : table) {
    RenderRequest r;
    r.rib = kHead + "Shutter 0 1\nWorldBegin\nTranslate 0 0 2\n" + glow(1) + object + row.transform +
            "ObjectInstance \"thing\"\nWorldEnd\n";
    r.settings.samplesPerPixel = 1024;
    SceneRender s(r);
    ASSERT_TRUE(s.ok()) << row.what;
    int told = 0;
    for (const std::string& m : s.messages())
      told += m.find("RENDER-FLAT") != std::string::npos && m.find("'thing'") != std::string::npos &&
              (m.find(":11:") != std::string::npos || m.find(":12:") != std::string::npos);
    EXPECT_EQ(told > 0, row.isLost) << row.what << (s.messages().empty() ? "" : ": " + s.messages()[0]);
    const double alpha = overPixels(s.channel("a")).mean();
    if (row.isLost)
      EXPECT_EQ(alpha, 0) << row.what;
    else
      EXPECT_GT(alpha, 0.05) << row.what;
  }
}

// The camera's own numbers, beyond what rays hold.
TEST(Objects, CamerasBeyondNumbersAreToldAndDrawSomething) {
  for (const std::string& line :
       {std::string("ScreenWindow -1e19 1e19 -1e19 1e19\n"), std::string("Clipping 1e19 3e38\n"),
        std::string("Projection \"perspective\" \"fov\" [60]\nDepthOfField 1e-30 1e18 1e18\n")}) {
    RenderRequest r;
    r.rib = kHead + line + "WorldBegin\nTranslate 0 0 2\n" + glow(1) + kPatch + "WorldEnd\n";
    SceneRender s(r);
    ASSERT_TRUE(s.ok()) << line;
    int told = 0;
    for (const std::string& m : s.messages()) told += m.find("RENDER-CAMERA") != std::string::npos;
    EXPECT_EQ(told, 1) << line;
    EXPECT_GT(overPixels(s.channel("a")).mean(), 0.5) << line;
  }
}

}  // namespace
}  // namespace kinora::tests
