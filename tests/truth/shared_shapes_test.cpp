// Proves: small quadrics that share a tessellation of size 1, and patches that share a mesh, look as each by itself
// does: outlines, normals, u and v, positions and lengths in object space, attributes and primvars of each; that they
// do share, and that bad sizes among them are left out with a message. A primvar that lives in the object's space
// keeps quadrics from sharing, attributes of their own patches. Misses: memory and time, which kinora-bench measures.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "support/render_scene.h"

namespace kinora::tests {
namespace {

const std::string kHead =
    "Format 96 96 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [64] \"int minsamples\" [64]\n"
    "Shutter 0 1\nProjection \"perspective\" \"fov\" [40]\nWorldBegin\nLight \"PxrDomeLight\" \"d\"\n";

std::string number(double x) { return std::to_string(x) + " "; }

struct Look {
  const char *name, *text;
};
const Look kLooks[] = {
    {"diffuse", "Bxdf \"PxrDiffuse\" \"m\"\n"},
    {"st",
     "Pattern \"PxrPrimvar\" \"p\" \"string varname\" [\"st\"] \"string type\" [\"float2\"]\nBxdf \"PxrConstant\" "
     "\"c\" "
     "\"reference color emitColor\" [\"p:resultRGB\"]\n"},
    {"object space",
     "Pattern \"PxrManifold3D\" \"own\" \"int use\" [0] \"string coordsys\" [\"object\"]\nPattern \"PxrFractal\" "
     "\"veins\" \"reference struct manifold\" [\"own:result\"] \"float frequency\" [.3]\nBxdf \"PxrConstant\" \"c\" "
     "\"reference color emitColor\" [\"veins:resultRGB\"]\n"},
    {"colours of each",
     "Pattern \"PxrPrimvar\" \"p\" \"string varname\" [\"Cs\"] \"string type\" [\"color\"]\nBxdf \"PxrConstant\" "
     "\"c\" "
     "\"reference color emitColor\" [\"p:resultRGB\"]\n"},
};

image::Image picture(const std::string& world, uint64_t& primitives, std::vector<std::string>* messages = nullptr) {
  RenderRequest r;
  r.rib = kHead + world + "WorldEnd\n";
  SceneRender s(r);
  EXPECT_TRUE(s.ok());
  if (!s.ok()) return {};
  primitives = s.renderer().statistics().primitives;
  if (messages) *messages = s.messages();
  return s.channel("Ci");
}

// Ten by ten of a primitive, each turned, sized, mirrored and coloured in its own way; about seven pixels wide each.
std::string hundred(const std::string& look, const std::string& primitive, bool isMoving) {
  std::string text = look;
  for (int i = 0; i < 100; ++i) {
    text +=
        "AttributeBegin\nColor " + number(.2 + .008 * i) + number(.9 - .007 * i) + number(.3 + .1 * (i % 5)) + "\n";
    if (isMoving) text += "MotionBegin [0 1]\nTranslate 0 0 0\nTranslate .5 0 0\nMotionEnd\n";
    text += "Translate " + number(i % 10 * 2.2 - 9.9) + number(i / 10 * 2.2 - 9.9) + " 32\nRotate " + number(37 * i) +
            " .3 1 .2\nScale " + number(i % 3 ? 1 : -1) + " 1 1\n" + primitive + "AttributeEnd\n";
  }
  return text;
}

void expectAlike(const image::Image& a, const image::Image& b, const std::string& what) {
  ASSERT_EQ(a.width(), 96) << what;
  ASSERT_EQ(b.width(), 96) << what;
  double sumA = 0, sumB = 0, square = 0;
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 96; ++x)
      for (int c = 0; c < 3; ++c) {
        const double p = double(a.at(x, y)[size_t(c)]), q = double(b.at(x, y)[size_t(c)]);
        sumA += p, sumB += q, square += (p - q) * (p - q);
      }
  const double values = 96 * 96 * 3;
  EXPECT_GT(sumA / values, .05) << what;
  EXPECT_NEAR(sumA, sumB, .002 * sumA) << what;
  // 64 samples of a pixel, of which those on outlines may fall to either side
  EXPECT_LT(std::sqrt(square / values), .02) << what;
}

TEST(SharedShapes, QuadricsLookAsEachByItself) {
  const std::pair<const char*, const char*> kinds[] = {{"Sphere", "Sphere .8 -.8 .8 360"},
                                                       {"part of a sphere", "Sphere .8 -.4 .6 270"},
                                                       {"Disk", "Disk .2 .8 360"},
                                                       {"Cone", "Cone 1.2 .6 360"},
                                                       {"Cylinder", "Cylinder .5 -.6 .7 300"},
                                                       {"Paraboloid", "Paraboloid .7 0 1 360"},
                                                       {"Hyperboloid", "Hyperboloid .5 0 -.5 .2 .6 .5 360"},
                                                       {"Torus", "Torus .6 .2 0 360 360"}};
  for (const bool isMoving : {false, true})
    for (const auto& [name, request] : kinds)
      for (const Look& look : kLooks) {
        if (name != std::string("Sphere") && (isMoving || look.name == std::string("colours of each"))) continue;
        uint64_t shared = 0, apart = 0;
        const std::string what = std::string(name) + ", " + look.name + (isMoving ? ", moving" : "");
        const image::Image a = picture(hundred(look.text, std::string(request) + "\n", isMoving), shared);
        const image::Image b = picture(
            hundred(look.text, std::string(request) + " \"constant vector aside\" [0 0 1]\n", isMoving), apart);
        EXPECT_LE(shared, 3u) << what;  // sizes on screen differ a little
        EXPECT_EQ(apart, 100u) << what;
        expectAlike(a, b, what);
      }
}

TEST(SharedShapes, PatchesLookAsEachByItself) {
  const auto patches = [](bool areApart) {
    std::string text = "Sides 2\n";
    for (int i = 0; i < 300; ++i) {
      const double x = i % 20 * 1.1 - 11, y = i / 20 * 1.4 - 10;
      if (areApart) text += "AttributeBegin\n";
      text += "Patch \"bicubic\" \"P\" [";
      for (int b = 0; b < 4; ++b)
        for (int a = 0; a < 4; ++a)
          text += number(x + .33 * a + .1 * (b == 1)) + number(y + .4 * b) + number(32 + .5 * ((a + b + i) % 3));
      text += "] \"varying color Cs\" [1 0 0  0 1 0  0 0 1  1 1 " + number(i % 7 / 7.) +
              "] \"uniform float tone\" [" + number(i % 11 / 10.) + "] \"constant float shade\" [" +
              number(i % 13 / 12.) + "]\n";
      if (areApart) text += "Attribute \"user\" \"int x\" [1]\nAttributeEnd\n";
    }
    return text;
  };
  const std::string tones =
      "Pattern \"PxrPrimvar\" \"p\" \"string varname\" [\"tone\"] \"string type\" [\"float\"]\n"
      "Pattern \"PxrPrimvar\" \"q\" \"string varname\" [\"shade\"] \"string type\" [\"float\"]\n"
      "Pattern \"PxrToFloat3\" \"r\" \"reference float resultR\" [\"p:resultF\"] \"reference float resultG\" "
      "[\"q:resultF\"]\nBxdf \"PxrConstant\" \"c\" \"reference color emitColor\" [\"r:resultRGB\"]\n";
  for (const std::string& look :
       {std::string(kLooks[0].text), std::string(kLooks[1].text), std::string(kLooks[3].text), tones}) {
    uint64_t shared = 0, apart = 0;
    // an attribute of each block, said before its patch, makes lists of attributes of their own
    std::string separate = patches(true);
    for (size_t at = 0; (at = separate.find("AttributeBegin\n", at)) != std::string::npos; at += 15)
      separate.insert(at + 15, "Attribute \"user\" \"int own\" [1]\n");
    const image::Image a = picture(look + patches(false), shared), b = picture(look + separate, apart);
    EXPECT_EQ(shared, 1u);
    EXPECT_EQ(apart, 300u);
    expectAlike(a, b, look);
  }
}

// More than trace::BuildOptions::swarmFrom.
std::string thousands() {
  std::string text = "Bxdf \"PxrDiffuse\" \"m\" \"color diffuseColor\" [.6 .5 .4]\n";
  for (int i = 0; i < 10200; ++i)
    text += "TransformBegin\nTranslate " + number(i % 102 * .2 - 10) + number(i / 102 * .2 - 10) +
            number(30 + i % 7) + "\nSphere .09 -.09 .09 360\nTransformEnd\n";
  return text;
}

TEST(SharedShapes, SwarmsGiveTheSameBitsForAnyThreadsWidthsAndGroups) {
  uint64_t expected = 0;
  for (const auto& [threads, width, group] :
       {std::array{1, 8, 256}, std::array{2, 8, 256}, std::array{1, 1, 256}, std::array{2, 16, 512}}) {
    RenderRequest r;
    r.rib = kHead + thousands() + "WorldEnd\n";
    r.settings.threads = threads;
    r.settings.width = uint32_t(width);
    r.settings.groupSize = uint32_t(group);
    r.settings.samplesPerPixel = 4;
    SceneRender s(r);
    ASSERT_TRUE(s.ok());
    EXPECT_LE(s.renderer().statistics().primitives, 3u);
    EXPECT_EQ(s.renderer().statistics().instances, 10200u);
    const uint64_t hash = hashOf(s.film());
    if (!expected) expected = hash;
    EXPECT_EQ(hash, expected) << threads << " threads, width " << width << ", groups of " << group;
  }
}

TEST(SharedShapes, EditsGiveThePictureOfAFreshLoad) {
  RenderRequest base;
  base.rib = kHead + hundred(kLooks[2].text, "Sphere .8 -.8 .8 360\n", false) + "AttributeBegin\n" + kLooks[0].text;
  for (int i = 0; i < 300; ++i)
    base.rib += "Patch \"bilinear\" \"P\" [" + number(i % 20 - 10) + number(i / 20 - 8) + "31 " +
                number(i % 20 - 9.2) + number(i / 20 - 8) + "31 " + number(i % 20 - 10) + number(i / 20 - 7.2) +
                "32 " + number(i % 20 - 9.2) + number(i / 20 - 7.2) + "32]\n";
  base.rib += "AttributeEnd\nWorldEnd\n";
  base.settings.samplesPerPixel = 2;
  SceneRender s(base);
  ASSERT_TRUE(s.ok());
  uint64_t last = hashOf(s.film());
  const auto move = [](const scene::Transform& t, double z) {
    return concat(t, scene::Transform::fixed(scene::Matrix().setTranslation(Imath::V3d(0.1, 0, z))));
  };
  const std::pair<const char*, std::function<void(scene::Scene&)>> edits[] = {
      {"the camera comes closer",
       [&](auto& x) { x.cameras[0].worldToCamera = move(x.cameras[0].worldToCamera, -1); }},
      {"a sphere moves",
       [&](auto& x) { x.setPrimitiveTransform(x.primitives[7]->id, move(x.primitives[7]->toWorld, 2)); }},
      {"the first of them goes", [](auto& x) { x.removePrimitive(x.primitives[0]->id); }},
      {"a patch moves",
       [&](auto& x) { x.setPrimitiveTransform(x.primitives[150]->id, move(x.primitives[150]->toWorld, -3)); }},
      {"a patch has other attributes",
       [](auto& x) {
         auto a = std::make_shared<scene::Attributes>(*x.primitives[160]->attributes);
         a->color = {1, 0, 0};
         a->bxdf = nullptr;
         x.setPrimitiveAttributes(x.primitives[160]->id, a);
       }},
      {"the first patch goes", [](auto& x) { x.removePrimitive(x.primitives[99]->id); }},
      {"half the spheres go", [](auto& x) { x.primitives.erase(x.primitives.begin(), x.primitives.begin() + 50); }},
      {"half the patches go", [](auto& x) { x.primitives.resize(x.primitives.size() - 100); }},
      {"the camera goes far away",
       [&](auto& x) { x.cameras[0].worldToCamera = move(x.cameras[0].worldToCamera, 40); }}};
  for (const auto& [what, edit] : edits) {
    edit(s.renderer().scene());
    ASSERT_TRUE(s.renderer().update()) << what;
    ASSERT_EQ(s.renderer().renderFilm(), render::Outcome::Complete) << what;
    RenderRequest again = base;
    again.edit = [&](scene::Scene& x) { x = s.renderer().scene(); };
    SceneRender fresh(again);
    ASSERT_TRUE(fresh.ok()) << what;
    const uint64_t hash = hashOf(s.film());
    EXPECT_EQ(hash, hashOf(fresh.film())) << what;
    EXPECT_NE(hash, last) << what << ": nothing is seen of it";
    last = hash;
  }
}

TEST(SharedShapes, BadSizesAreLeftOut) {
  uint64_t count = 0;
  std::vector<std::string> messages;
  std::string text = "Bxdf \"PxrDiffuse\" \"m\"\n" + hundred("", "Sphere .8 -.8 .8 360\n", false);
  text +=
      "Sphere 0 0 0 360\nTransformBegin\nTranslate 0 0 20\nScale 0 0 0\nSphere 1 -1 1 360\nTransformEnd\n"
      "Sphere 1e38 -1e38 1e38 360\nTranslate 0 0 32\nSphere 1e-40 -1e-40 1e-40 360\nSphere 1 -1 1 0\n";
  picture(text, count, &messages);
  EXPECT_GE(count, 4u);
  std::string all;
  for (const std::string& m : messages) all += m;
  EXPECT_NE(all.find("GEOM-ZERO-AREA"), std::string::npos) << all;
}

}  // namespace
}  // namespace kinora::tests
