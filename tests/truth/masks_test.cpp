// Proves: what is cut from a picture and what rays are kept from: clipping planes, holes (Matte, trace:holdout),
// subsets of objects for rays, windows and aspect ratios, the shadow terminator's correction. Misses: subsets for
// lights' shadows (shadowSubset of a light).
#include <gtest/gtest.h>

#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

std::string glow(const char* rgb) {
  return std::string("Bxdf \"PxrConstant\" \"c\" \"color emitColor\" [") + rgb + "]\n";
}
std::string sheet(double z, double x0 = -50, double x1 = 50) {
  const std::string a = std::to_string(x0), b = std::to_string(x1), d = std::to_string(z);
  return "Polygon \"vertex point P\" [" + a + " -50 " + d + " " + a + " 50 " + d + " " + b + " 50 " + d + " " + b +
         " -50 " + d + "]\n";
}
int messagesOf(const SceneRender& r, const char* code) {
  int n = 0;
  for (const std::string& m : r.messages()) n += m.find(code) != std::string::npos;
  return n;
}

TEST(Clipping, PlanesCutWhatTheySay) {
  const std::string three = glow("1 0 0") + sheet(1) + glow("0 1 0") + sheet(3) + glow("0 0 1") + sheet(5);
  struct Case {
    const char* name;
    std::string head;
    std::array<double, 4> rgba;  // means
  };
  const Case cases[] = {
      {"none", "", {1, 0, 0, 1}},
      {"near", "Clipping 2 100\n", {0, 1, 0, 1}},
      {"far before everything", "Clipping 0.1 0.5\n", {0, 0, 0, 0}},
      {"between", "Clipping 3.5 4\n", {0, 0, 0, 0}},
      {"plane facing the camera", "ClippingPlane 0 0 2  0 0 -1\n", {0, 1, 0, 1}},
      {"half of the first sheet", "ClippingPlane 0 0 0  1 0 0\n", {0.5, 0, 0, 0.5}},
      {"in a space that is turned", "Rotate 90 0 1 0\nClippingPlane 0 0 0  0 0 1\nIdentity\n", {0.5, 0, 0, 0.5}},
      {"a wedge",
       "ClippingPlane 0 0 2  0 0 -1\nClippingPlane 0 0 4  0 0 1\nClippingPlane 0 0 0  0 1 0\n",
       {0, 0.5, 0, 0.5}},
  };
  for (const char* projection : {"Projection \"orthographic\"\n", "Projection \"perspective\" \"fov\" [60]\n"})
    for (const Case& c : cases) {
      RenderRequest r;
      r.rib = "Format 8 8 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [64]\n" +
              std::string(projection) + c.head + "WorldBegin\n" + three + "WorldEnd\n";
      SceneRender render(r);
      ASSERT_TRUE(render.ok()) << c.name;
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(overPixels(render.channel("Ci"), k).mean(), c.rgba[size_t(k)], 1e-5)
            << c.name << " " << projection;
      EXPECT_NEAR(overPixels(render.channel("a")).mean(), c.rgba[3], 1e-5) << c.name;
    }
}

TEST(Holes, HideWithoutBeingSeen) {
  // a glowing wall and a sky behind, and a sheet that covers the left half
  for (const char* hole :
       {"Matte 1\n", "Attribute \"trace\" \"int holdout\" [1]\n", "Attribute \"Ri\" \"int Matte\" [1]\n"})
    for (const bool instance : {false, true}) {
      std::string half = "AttributeBegin\n" + std::string(hole);
      half += instance ? "ObjectInstance \"half\"\n" : glow("5 5 5") + sheet(1, -50, 0);
      RenderRequest r;
      r.rib = orthographic(8, 1, 16) +
              "WorldBegin\nLight \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\nObjectBegin \"half\"\n" +
              glow("5 5 5") + sheet(1, -50, 0) + "ObjectEnd\n" + half + "AttributeEnd\n" + glow("0 1 0") +
              sheet(3, -0.5, 0.5) + "WorldEnd\n";
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      // right: a quarter green wall, a quarter sky (white, alpha 0)
      EXPECT_NEAR(overPixels(render.channel("Ci"), 0).mean(), 0.25, 1e-5) << hole;
      EXPECT_NEAR(overPixels(render.channel("Ci"), 1).mean(), 0.5, 1e-5) << hole;
      EXPECT_NEAR(overPixels(render.channel("a")).mean(), 0.25, 1e-5) << hole;
    }
  // to other rays it is an object like any other: a white floor sees it glow
  const auto floor = [](const char* attribute) {
    RenderRequest r;
    r.rib = orthographic(8, 1, 256) + unbiased(1) +
            "WorldBegin\nBxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [1 1 1]\n" + sheet(1) +
            "Attribute \"visibility\" \"int camera\" [0]\n" + attribute + glow("1 1 1") + sheet(-1) + "WorldEnd\n";
    SceneRender render(r);
    return overPixels(render.channel("Ci")).mean();
  };
  EXPECT_NEAR(floor("Matte 1\n"), floor(""), 1e-6);
  EXPECT_GT(floor("Matte 1\n"), 0.9);
}

// A white wall lit by a distant light, with a screen before it that the camera does not see, and a glowing sheet
// behind the camera that indirect rays find.
TEST(Subsets, RaysSeeTheGroupsTheyAreTold) {
  const auto mean = [](const std::string& wall, int* messages = nullptr) {
    RenderRequest r;
    r.rib = orthographic(8, 1e-3, 64) + unbiased(1) +
            "WorldBegin\nLight \"PxrDistantLight\" \"l\" \"float intensity\" [1000] \"float angleExtent\" [1]\n"
            "Bxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [1 1 1]\nAttributeBegin\n" +
            wall + sheet(1) + "AttributeEnd\nAttribute \"visibility\" \"int camera\" [0]\nAttributeBegin\n" +
            "Attribute \"grouping\" \"string membership\" [\"screens dark\"]\n" +
            "Bxdf \"PxrDiffuse\" \"dark\" \"color diffuseColor\" [0 0 0]\n" + sheet(0.5) +
            "AttributeEnd\nAttributeBegin\n" +
            "Attribute \"grouping\" \"string membership\" [\"+glowing\"]\nAttribute \"visibility\" \"int "
            "transmission\" [0]\n" +
            glow("1 1 1") + sheet(-2) + "AttributeEnd\nWorldEnd\n";
    SceneRender render(r);
    if (messages) *messages = messagesOf(render, "RENDER-TRACE-SET");
    return overPixels(render.channel("Ci")).mean();
  };
  const double s = std::sin(0.5 * 3.14159265358979 / 180), lit = 1000 * s * s;
  const auto trace = [](const std::string& name, const std::string& value) {
    return "Attribute \"trace\" \"string " + name + "\" [\"" + value + "\"]\n";
  };
  EXPECT_NEAR(mean(""), 0, 1e-6) << "the screen shadows and hides the glow";
  EXPECT_NEAR(mean(trace("shadowexcludesubset", "screens")), lit, 0.01 * lit);
  EXPECT_NEAR(mean(trace("shadowsubset", "glowing")), lit, 0.01 * lit);
  EXPECT_NEAR(mean(trace("shadowsubset", "glowing dark")), 0, 1e-6);
  EXPECT_NEAR(mean(trace("reflectexcludesubset", "screens")), 1, 0.01);
  EXPECT_NEAR(mean(trace("reflectsubset", "glowing")), 1, 0.01);
  EXPECT_NEAR(mean(trace("reflectsubset", "screens")), 0, 1e-6);
  EXPECT_NEAR(mean(trace("reflectsubset", "glowing") + trace("shadowexcludesubset", "screens")), 1 + lit,
              0.02 * (1 + lit));
  EXPECT_NEAR(mean(trace("transmitsubset", "glowing")), 0, 1e-6) << "nothing is transmitted";
  int messages = 0;
  EXPECT_NEAR(mean(trace("shadowsubset", "nobody"), &messages), lit, 0.01 * lit) << "no object is in that group";
  EXPECT_EQ(messages, 1);
}

// The same of media: fog between the wall and what lights it dims, glows and is seen for the rays of those objects alone
// whose subsets it is a member of, whether its boundary is a box or a mesh.
TEST(Subsets, MediaAreMembersAsSurfacesAre) {
  const std::string sun = "Light \"PxrDistantLight\" \"l\" \"float intensity\" [1000] \"float angleExtent\" [1]\n";
  const std::string behind =
      "Attribute \"visibility\" \"int camera\" [0] \"int transmission\" [0]\n" + glow("1 1 1") + sheet(-2);
  const std::string absorbs = "\"color diffuseColor\" [0 0 0] \"color densityColor\" [2 2 2]";
  const std::string glows = "\"float densityFloat\" [0] \"color emitColor\" [1 1 1]";
  const auto mean = [](const std::string& light, const std::string& walls, const std::string& material,
                       const std::string& shape, bool isSeen = false) {
    RenderRequest r;
    r.rib = orthographic(8, 1e-3, 64) + unbiased(1) +
            "WorldBegin\nBxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [1 1 1]\n" + walls +
            "AttributeBegin\nAttribute \"grouping\" \"string membership\" [\"fog\"]\nAttribute \"visibility\" \"int "
            "camera\" [" +
            (isSeen ? "1" : "0") + "]\nBxdf \"PxrVolume\" \"fog\" " + material + "\nVolume \"" + shape +
            "] [0 0 0]\nAttributeEnd\n" + light + "WorldEnd\n";
    SceneRender render(r);
    return overPixels(render.channel("Ci")).mean();
  };
  const auto asking = [](const std::string& name, double x0 = -50, double x1 = 50) {
    return "AttributeBegin\nAttribute \"trace\" \"string " + name + "\" [\"fog\"]\n" + sheet(1, x0, x1) +
           "AttributeEnd\n";
  };
  const std::string slab = "box\" [-60 60 -60 60 .2 .6";
  const double s = std::sin(0.5 * 3.14159265358979 / 180), lit = 1000 * s * s, left = std::exp(-2 * 0.4);

  for (const std::string& shape : {slab, std::string("ellipsoid\" [-1 1 -1 1 .2 .6")}) {
    const auto inTheSun = [&](const std::string& walls) { return mean(sun, walls, absorbs, shape) / lit; };
    EXPECT_NEAR(inTheSun(sheet(1)), left, 0.02) << shape;
    EXPECT_NEAR(inTheSun(asking("shadowexcludesubset")), 1, 0.02) << shape;
    EXPECT_NEAR(inTheSun(asking("shadowsubset")), left, 0.02) << "it is a member";
    EXPECT_NEAR(inTheSun(asking("reflectexcludesubset")), left, 0.02) << "lights are found by shadows' rules";
    // of rays in one group some know of it
    EXPECT_NEAR(inTheSun(asking("shadowexcludesubset", -50, 0) + sheet(1, 0, 50)), (1 + left) / 2, 0.02) << shape;
  }
  EXPECT_NEAR(mean(sun, asking("shadowexcludesubset"), absorbs, slab, true) / lit, left, 0.03)
      << "the camera sees it all the same";

  // what diffuse rays bring through a slab: twice the exponential integral E3 of its depth
  double diffuse = 0;
  for (int i = 0; i < 1000; ++i) {
    const double cosine = (i + 0.5) / 1000;
    diffuse += 2 * cosine * std::exp(-0.8 / cosine) / 1000;
  }
  EXPECT_NEAR(mean(behind, sheet(1), absorbs, slab), diffuse, 0.03);
  EXPECT_NEAR(mean(behind, asking("reflectexcludesubset"), absorbs, slab), 1, 0.01);
  EXPECT_NEAR(mean(behind, asking("transmitexcludesubset"), absorbs, slab), diffuse, 0.03);
  EXPECT_NEAR(mean(behind, asking("shadowexcludesubset"), absorbs, slab), diffuse, 0.03);

  // what it emits: along a ray its length, by cosine twice its thickness; light samples find no more than rays do
  EXPECT_NEAR(mean("", sheet(1), glows, slab), 0.8, 0.08);
  EXPECT_NEAR(mean("", asking("shadowexcludesubset"), glows, slab), 0.8, 0.08);
  EXPECT_NEAR(mean("", asking("reflectexcludesubset"), glows, slab), 0, 1e-6);
}

// What a pane of glass lets through is its transmitted rays.
TEST(Subsets, TransmittedRays) {
  const auto mean = [](const std::string& pane, const std::string& more = "") {
    RenderRequest r;
    r.rib = orthographic(8, 1e-3, more.empty() ? 16 : 64) + unbiased(4) + "WorldBegin\n" + more + "AttributeBegin\n" +
            pane +
            "Bxdf \"PxrSurface\" \"glass\" \"float diffuseGain\" [0] \"float refractionGain\" [1] \"float "
            "reflectionGain\" [0] "
            "\"float glassRoughness\" [0] \"float glassIor\" [1]\n" +
            sheet(1) + "AttributeEnd\nAttributeBegin\nAttribute \"grouping\" \"string membership\" [\"near\"]\n" +
            glow("1 1 1") + sheet(2) +
            "AttributeEnd\nAttributeBegin\nAttribute \"grouping\" \"string membership\" [\"far\"]\n" + glow("3 3 3") +
            sheet(3) + "AttributeEnd\nWorldEnd\n";
    SceneRender render(r);
    return overPixels(render.channel("Ci")).mean();
  };
  EXPECT_NEAR(mean(""), 1, 0.01);
  EXPECT_NEAR(mean("Attribute \"trace\" \"string transmitsubset\" [\"far\"]\n"), 3, 0.03);
  EXPECT_NEAR(mean("Attribute \"trace\" \"string transmitexcludesubset\" [\"near\"]\n"), 3, 0.03);
  EXPECT_NEAR(mean("Attribute \"trace\" \"string reflectsubset\" [\"far\"]\n"), 1, 0.01);
  // and fog behind the pane is in their way, or not
  const std::string fog =
      "Bxdf \"PxrVolume\" \"fog\" \"color diffuseColor\" [0 0 0] \"color densityColor\" [2 2 2]\n"
      "AttributeBegin\nAttribute \"grouping\" \"string membership\" [\"fog\"]\n"
      "Volume \"box\" [-9 9 -9 9 1.2 1.6] [0 0 0]\nAttributeEnd\n";
  const double left = std::exp(-2 * 0.4);
  EXPECT_NEAR(mean("", fog), left, 0.03);
  EXPECT_NEAR(mean("Attribute \"trace\" \"string transmitexcludesubset\" [\"fog\"]\n", fog), 1, 0.01);
  EXPECT_NEAR(mean("Attribute \"trace\" \"string reflectexcludesubset\" [\"fog\"]\n", fog), left, 0.03);
}

// A sphere of few polygons with its true normals, lit from the side. Facets near the terminator that are turned away
// from the light would be dark although their normals look at it; corrected, it is as bright as without any shadows.
// The angle leaves facets that are just turned away (their edges lie at multiples of 18 degrees).
TEST(ShadowTerminator, CoarseSmoothSphere) {
  const auto sphere = [](int nu, int nv) {
    std::string counts, indices, points, normals;
    for (int j = 0; j <= nv; ++j)
      for (int i = 0; i < nu; ++i) {
        const double a = 2 * 3.14159265358979 * i / nu, b = 3.14159265358979 * (double(j) / nv - 0.5);
        const std::string p = std::to_string(std::cos(a) * std::cos(b)) + " " + std::to_string(std::sin(b)) + " " +
                              std::to_string(std::sin(a) * std::cos(b)) + " ";
        points += p;
        normals += p;
      }
    for (int j = 0; j < nv; ++j)
      for (int i = 0; i < nu; ++i) {
        counts += "4 ";
        indices += std::to_string(j * nu + i) + " " + std::to_string((j + 1) * nu + i) + " " +
                   std::to_string((j + 1) * nu + (i + 1) % nu) + " " + std::to_string(j * nu + (i + 1) % nu) + " ";
      }
    return "PointsPolygons [" + counts + "] [" + indices + "] \"vertex point P\" [" + points +
           "] \"vertex normal N\" [" + normals + "]\n";
  };
  const auto brightness = [&](int correction, const std::string& attribute, const std::string& transform) {
    RenderRequest r;
    r.rib =
        "Format 48 48 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [64] \"int "
        "geomShadowTermBias\" [" +
        std::to_string(correction) + "]\nScreenWindow -1.1 1.1 -1.1 1.1\nProjection \"orthographic\"\n" +
        unbiased(0) +
        "Translate 0 0 5\nWorldBegin\nAttributeBegin Rotate 82 0 1 0\nLight \"PxrDistantLight\" \"l\" \"float "
        "intensity\" [1000] "
        "\"float angleExtent\" [1]\nAttributeEnd\nBxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [1 1 1]\n" +
        attribute + transform + sphere(20, 10) + "WorldEnd\n";
    SceneRender render(r);
    return overPixels(render.channel("Ci")).mean();
  };
  const double free = brightness(1, "Attribute \"visibility\" \"int transmission\" [0]\n", "");
  ASSERT_GT(free, 0);
  const double without = brightness(0, "", ""), with = brightness(1, "", "");
  EXPECT_LT(without, 0.985 * free) << "the scene shows the fault";
  EXPECT_NEAR(with, free, 0.004 * free);
  EXPECT_NEAR(brightness(1, "", "MotionBegin [0 1] Rotate 0 1 0 0 Rotate 0.001 1 0 0 MotionEnd\n"), with,
              0.004 * free)
      << "placed, not baked";
  // another object still shadows it
  EXPECT_NEAR(brightness(1,
                         glow("0 0 0") + "AttributeBegin Rotate 82 0 1 0 Translate 0 0 -3\n" + sheet(0) +
                             "AttributeEnd\nBxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [1 1 1]\n",
                         ""),
              0, 1e-6);
}

TEST(Windows, AspectScreenAndCrop) {
  // a bar over x in 0..1 of a world whose window is as the requests say
  const auto render = [](const std::string& head) {
    RenderRequest r;
    r.rib = "PixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [16]\nProjection \"orthographic\"\n" +
            head + "WorldBegin\n" + glow("1 1 1") + sheet(3, 0, 1) + "WorldEnd\n";
    return std::make_unique<SceneRender>(r);
  };
  const auto check = [&](const std::string& head, int width, int height, double coverage) {
    const auto r = render(head);
    ASSERT_TRUE(r->ok());
    const image::Image a = r->channel("a");
    EXPECT_EQ(a.width(), width) << head;
    EXPECT_EQ(a.height(), height) << head;
    EXPECT_NEAR(overPixels(a).mean(), coverage, 1e-3) << head;
  };
  check("Format 32 16 1\n", 32, 16, 0.25);   // -2..2
  check("Format 16 32 1\n", 16, 32, 0.5);    // -1..1
  check("Format 32 16 0.5\n", 32, 16, 0.5);  // square by its pixels
  check("Format 32 16 1\nScreenWindow -1 3 -1 1\n", 32, 16, 0.25);
  check("Format 32 16 1\nScreenWindow 0 1 0 1\n", 32, 16, 1);
  check("Format 32 16 1\nFrameAspectRatio 1\n", 16, 16, 0.5);       // the largest part of that shape
  check("Format 32 16 1\nFrameAspectRatio 4\n", 32, 8, 0.125);      // -4..4
  check("Format 32 16 1\nFrameAspectRatio 1.999\n", 32, 16, 0.25);  // a rounded 2
  const auto whole = render("Format 32 16 1\nScreenWindow -1 3 -1 1\n");
  const auto part = render("Format 32 16 1\nScreenWindow -1 3 -1 1\nCropWindow 0.25 0.75 0.5 1\n");
  const image::Image w = whole->channel("a"), p = part->channel("a");
  ASSERT_EQ(p.width(), 16);
  ASSERT_EQ(p.height(), 8);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 16; ++x) EXPECT_EQ(p.at(x + 8, y + 8)[0], w.at(x + 8, y + 8)[0]);
}

}  // namespace
}  // namespace kinora::tests
