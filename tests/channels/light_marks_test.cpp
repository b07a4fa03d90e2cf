// Proves: a PxrAovLight marks what it is linked to in its channel (at first hits, along reflections and refractions,
// weighed or not, inverted, in colour, through light filters), with the same bits for any group, and changes nothing
// else. Misses: volumes, motion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/render_scene.h"

namespace kinora::tests {
namespace {

// An orthographic view of the square -1..1: a ball on the left, "in", and one on the right, "out", for which the light
// is off.
RenderRequest balls(const std::string& light, const std::string& filter = "", const std::string& type = "float") {
  RenderRequest r;
  r.rib =
      "Hider \"raytrace\" \"int maxsamples\" [16]\nFormat 32 32 1\nPixelFilter \"box\" 1 1\n"
      "Integrator \"PxrPathTracer\" \"i\"\nProjection \"orthographic\"\n"
      "DisplayChannel \"" +
      type +
      " mask\"\n"
      "WorldBegin\nLight \"PxrDomeLight\" \"sky\"\n" +
      filter + light +
      "AttributeBegin\nTranslate -0.5 0 5\nSphere 0.4 -0.4 0.4 360\nAttributeEnd\n"
      "AttributeBegin\nIlluminate \"marks\" 0\nTranslate 0.5 0 5\nSphere 0.4 -0.4 0.4 360\nAttributeEnd\nWorldEnd\n";
  r.channels = "Ci,a,mask";
  return r;
}
std::string aovLight(const std::string& more = "") {
  return "Light \"PxrAovLight\" \"marks\" \"string aovName\" [\"mask\"] " + more + "\n";
}

TEST(LightMarks, MaskIsTheCoverageOfWhatIsLinked) {
  SceneRender r(balls(aovLight())), inverted(balls(aovLight("\"int invert\" [1]")));
  ASSERT_TRUE(r.ok() && inverted.ok());
  EXPECT_TRUE(r.messages().empty()) << r.messages()[0];
  const image::Image a = r.channel("a"), mask = r.channel("mask"), other = inverted.channel("mask");
  int mixed = 0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      const float alpha = a.at(x, y)[0];
      EXPECT_FLOAT_EQ(mask.at(x, y)[0], x < 16 ? alpha : 0.f) << x << " " << y;
      EXPECT_FLOAT_EQ(other.at(x, y)[0], x < 16 ? 0.f : alpha) << x << " " << y;
      mixed += alpha > 0 && alpha < 1;
    }
  EXPECT_GT(mixed, 20);
}

// Filters with linkingGroups change the marks of those objects only that they are on (lightfilter:subset).
TEST(LightMarks, FiltersAreOnTheObjectsOfTheirGroups) {
  const auto filter = [](const char* handle, const char* groups, const char* factor) {
    return std::string("LightFilter \"PxrIntMultLightFilter\" \"") + handle + "\" \"float intensity\" [" + factor +
           "] \"string linkingGroups\" [\"" + groups + "\"]\n";
  };
  RenderRequest r = balls(aovLight(), filter("a", "warm", "0.5") + filter("b", "cold", "0.25"));
  const auto link = [&](const char* before, const char* subset) {
    const size_t at = r.rib.find(before);
    r.rib.insert(at, std::string("Attribute \"lightfilter\" \"string subset\" [\"") + subset + "\"]\n");
  };
  link("Translate -0.5", "warm");
  link("Illuminate", "cold");
  r.rib.erase(r.rib.find("Illuminate"), std::string("Illuminate \"marks\" 0\n").size());
  for (const uint32_t width : {1u, 8u}) {
    r.settings.width = width;
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    EXPECT_TRUE(render.messages().empty()) << render.messages()[0];
    EXPECT_EQ(render.channel("mask").at(8, 16)[0], 0.5f);
    EXPECT_EQ(render.channel("mask").at(24, 16)[0], 0.25f);
  }
}

TEST(LightMarks, NothingElseChanges) {
  RenderRequest plain = balls(""), marked = balls(aovLight("\"int inReflection\" [1] \"int inRefraction\" [1]"));
  // the same primvar is asked for and not there
  plain.channels = marked.channels = "Ci,a";
  SceneRender a(plain), b(marked);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(hashOf(a.film()), hashOf(b.film()));
  EXPECT_TRUE(std::any_of(b.messages().begin(), b.messages().end(),
                          [](const std::string& m) { return m.find("LIGHT-CHANNEL") != std::string::npos; }));
}

TEST(LightMarks, ColourAndFilters) {
  const float color[3] = {0.5f, 0.25f, 1};
  const float grey = 0.2126f * color[0] + 0.7152f * color[1] + 0.0722f * color[2];
  const auto middle = [](const std::string& light, const char* type, const std::string& filter = "") {
    SceneRender r(balls(light, filter, type));
    EXPECT_TRUE(r.ok());
    const image::Image c = r.channel("mask");
    const float* p = c.at(8, 16);
    return std::array<float, 3>{p[0], p[c.channelCount() > 1], p[c.channelCount() > 2 ? 2 : 0]};
  };
  const std::string colored =
      aovLight("\"color lightColor\" [0.5 0.25 1] \"int useColor\" [1] \"float exposure\" [1]");
  const auto rgb = middle(colored, "color");
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(rgb[c], 2 * color[c], 1e-5);
  EXPECT_NEAR(middle(colored, "float")[0], 2 * grey, 1e-5) << "of one float: the luminance";
  for (const float v : middle(aovLight("\"color lightColor\" [0.5 0.25 1]"), "color")) EXPECT_NEAR(v, grey, 1e-5);
  const std::string half = "LightFilter \"PxrIntMultLightFilter\" \"f\" \"float intensity\" [0.25]\n";
  EXPECT_NEAR(middle(aovLight(), "float", half)[0], 0.25f, 1e-5);
  EXPECT_NEAR(middle(aovLight() + "Light \"PxrAovLight\" \"more\" \"string aovName\" [\"mask\"]\n", "float")[0], 2,
              1e-5)
      << "lights of one channel add up";
}

// A mirror of 45 degrees shows a wall beside the view that fills it.
TEST(LightMarks, ReflectionsShowIt) {
  const auto mean = [](const std::string& more, const std::string& face) {
    RenderRequest r;
    r.rib =
        "Hider \"raytrace\" \"int maxsamples\" [64]\nFormat 8 8 1\nPixelFilter \"box\" 1 1\n"
        "Integrator \"PxrPathTracer\" \"i\"\nProjection \"orthographic\"\nDisplayChannel \"float mask\"\nWorldBegin\n"
        "Light \"PxrDomeLight\" \"sky\"\n" +
        aovLight(more) +
        "AttributeBegin\nIlluminate \"marks\" 0\nBxdf \"PxrSurface\" \"mirror\" \"float diffuseGain\" [0] "
        "\"color specularFaceColor\" [" +
        face + "] \"color specularEdgeColor\" [" + face +
        "] \"float specularRoughness\" [0]\n"
        "Polygon \"P\" [-2 -2 3  -2 2 3  2 2 7  2 -2 7]\nAttributeEnd\n"
        "AttributeBegin\nBxdf \"PxrDiffuse\" \"wall\"\nPolygon \"P\" [9 -9 -9  9 -9 29  9 9 29  9 9 -9]\n"
        "AttributeEnd\nWorldEnd\n";
    r.channels = "Ci,mask";
    SceneRender s(r);
    EXPECT_TRUE(s.ok());
    return overPixels(s.channel("mask"));
  };
  EXPECT_EQ(mean("", "1 1 1").mean(), 0) << "the camera sees the mirror alone";
  const std::string shown = "\"int inReflection\" [1] ";
  EXPECT_MEAN(mean(shown, "1 1 1"), 1, 0.01);
  EXPECT_MEAN(mean(shown, "0.25 0.25 0.25"), 0.25, 0.02);
  // no sample's path is lost before it has found the wall
  EXPECT_NEAR(mean(shown + "\"int useThroughput\" [0]", "1 1 1").mean(), 1, 0.01);
  EXPECT_EQ(mean("\"int inRefraction\" [1]", "1 1 1").mean(), 0);
}

// A pane of glass before the ball.
TEST(LightMarks, RefractionsShowIt) {
  const auto mean = [](const std::string& more) {
    RenderRequest r = balls(aovLight("\"int useThroughput\" [0] " + more));
    const std::string at = "AttributeBegin\nTranslate -0.5";
    r.rib.insert(r.rib.find(at),
                 "AttributeBegin\nIlluminate \"marks\" 0\nBxdf \"PxrGlass\" \"glass\" \"float ior\" [1.0001]\n"
                 "Polygon \"P\" [-2 -2 2  2 -2 2  2 2 2  -2 2 2]\nAttributeEnd\n");
    SceneRender s(r);
    EXPECT_TRUE(s.ok());
    return s.channel("mask").at(8, 16)[0];
  };
  EXPECT_EQ(mean(""), 0);
  EXPECT_EQ(mean("\"int inReflection\" [1]"), 0);
  EXPECT_NEAR(mean("\"int inRefraction\" [1]"), 1, 1e-3) << "hardly anything is reflected";
}

TEST(LightMarks, EditsOfLinksAreSeen) {
  SceneRender r(balls(aovLight()));
  ASSERT_TRUE(r.ok());
  scene::Scene& s = r.renderer().scene();
  ASSERT_EQ(s.primitives.size(), 2u);
  for (auto& p : s.primitives) {
    auto changed = std::make_shared<scene::Primitive>(*p);
    changed->attributes = s.primitives[0]->attributes;  // those of the ball that is marked
    p = changed;
  }
  ASSERT_TRUE(r.renderer().update());
  ASSERT_EQ(r.renderer().render(), render::Outcome::Complete);
  const image::Image a = r.channel("a"), mask = r.channel("mask");
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) EXPECT_FLOAT_EQ(mask.at(x, y)[0], a.at(x, y)[0]) << x << " " << y;
}

TEST(LightMarks, SameBitsAtAllWidthsThreadsAndGroups) {
  RenderRequest q =
      balls(aovLight("\"int inReflection\" [1] \"color lightColor\" [0.3 0.6 0.1] \"int useColor\" [1]"),
            "LightFilter \"PxrRodLightFilter\" \"f\" \"float edge\" [2]\n");
  const std::string dull = "AttributeBegin\nTranslate -0.5";
  q.rib.insert(q.rib.find(dull),
               "Bxdf \"PxrSurface\" \"s\" \"color specularFaceColor\" [0.4 0.5 0.6] "
               "\"float specularRoughness\" [0.2]\n");
  hashHoweverRendered(q);
}

}  // namespace
}  // namespace kinora::tests
