// Proves: the light that a white diffuse plane sends back is the closed form of its irradiance over pi, within 0.3 %,
// for each analytic light, by light samples with bxdf samples, and by bxdf samples alone where lights can be hit; the
// two integrators agree on direct light; numbers of samples, clamps and roulette change no mean. Misses: maps and
// shaping of lights (their own tests), and specular receivers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

constexpr double kPi = 3.14159265358979323846;

// A white plane at z = 1 that faces the camera, which looks at one point of it from the plane z = 0; lights with z <
// 0 stand behind the camera and emit along +z unless turned.
std::string whitePlane(const std::string& light, const std::string& integrator, const std::string& turned = "") {
  return orthographic(16, 1e-4, 64) + integrator + "WorldBegin\n" + light +
         "Bxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [1 1 1]\nAttributeBegin Translate 0 0 1 " + turned +
         "\nPolygon \"vertex point P\" [-50 -50 0  -50 50 0  50 50 0  50 -50 0]\nAttributeEnd\nWorldEnd\n";
}

void expectRadiance(const std::string& rib, double expected, const std::string& what) {
  RenderRequest r;
  r.rib = rib;
  testing::Moments m;
  for (uint32_t seed = 1; seed <= 64; ++seed) {
    r.settings.seed = seed;
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    const image::Image picture = render.channel("Ci");
    for (size_t i = 0; i < picture.pixels.size(); i += 3) m.add(picture.pixels[i]);
    if (m.standardError() <= 8e-4 * expected) break;
  }
  EXPECT_NEAR(m.mean(), expected, 3e-3 * expected) << what << ", standard error " << m.standardError();
  EXPECT_LE(m.standardError(), 1e-3 * expected) << what << ": too noisy to judge";
}

void expectIrradiance(const std::string& light, double irradiance, const std::string& what,
                      const std::string& turned = "") {
  for (const char* integrator : {"numLightSamples", "numIndirectSamples"})
    expectRadiance(whitePlane(light, unbiased(0, std::string("\"int ") + integrator + "\" [4]"), turned),
                   irradiance / kPi, what + " by the path tracer, 4 " + integrator);
  expectRadiance(whitePlane(light, "Integrator \"PxrDirectLighting\" \"i\"\n", turned), irradiance / kPi,
                 what + " by PxrDirectLighting");
}
void expectByBxdfSamplesAlone(const std::string& light, double irradiance, const std::string& what) {
  expectRadiance(whitePlane(light, unbiased(0, "\"int numLightSamples\" [0]")), irradiance / kPi,
                 what + " by bxdf samples");
}

TEST(Irradiance, OfARectangle) {
  for (const double height : {0.3, 2.0}) {
    // side 1, above the point: E = 4 L (a / q) atan(a / q), q^2 = a^2 + h^2
    const double a = 0.5, q = std::sqrt(a * a + height * height), e = 4 * a / q * std::atan(a / q);
    const std::string light = "AttributeBegin Translate 0 0 " + std::to_string(1 - height) +
                              " Light \"PxrRectLight\" \"l\" \"float intensity\" [1] AttributeEnd\n";
    if (height > 1) expectIrradiance(light, e, "rectangle at 2");
    if (height < 1) {
      // between camera and plane: its dark back must not be in the way of the view for this test
      const std::string unseen =
          "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\n" + light + "AttributeEnd\n";
      expectIrradiance(unseen, e, "rectangle at 0.3");
      expectByBxdfSamplesAlone(unseen, e, "rectangle at 0.3");
    }
  }
}

TEST(Irradiance, OfASphere) {
  for (const double distance : {0.7, 4.0}) {
    // radius 0.5 overhead: E = pi L (r / d)^2
    const double e = kPi * 0.25 / (distance * distance);
    const std::string light = "AttributeBegin Translate 0 0 " + std::to_string(1 - distance) +
                              " Light \"PxrSphereLight\" \"l\" \"float intensity\" [1] AttributeEnd\n";
    // the nearer one stands between camera and plane
    expectIrradiance("AttributeBegin Attribute \"visibility\" \"int camera\" [0]\n" + light + "AttributeEnd\n", e,
                     "sphere");
    // far off it is found too rarely to be judged
    if (distance < 1)
      expectByBxdfSamplesAlone(
          "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\n" + light + "AttributeEnd\n", e, "sphere");
  }
}

const std::string kUnseen = "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\n";

TEST(Irradiance, OfADisk) {
  for (const double height : {0.3, 2.0}) {
    // radius 0.5 overhead: E = pi L r^2 / (r^2 + h^2)
    const double e = kPi * 0.25 / (0.25 + height * height);
    const std::string light = kUnseen + "Translate 0 0 " + std::to_string(1 - height) +
                              " Light \"PxrDiskLight\" \"l\" \"float intensity\" [1] AttributeEnd\n";
    expectIrradiance(light, e, "disk");
    if (height < 1) expectByBxdfSamplesAlone(light, e, "disk");
  }
  // aslant and squeezed: the plane sees it edge-on in part; closed form by its own polygon (the light's test proves
  // it) is not asked here, but the two techniques must agree
  const std::string askew =
      kUnseen +
      "Translate 0.4 0 0.2 Rotate 60 0 1 0 Scale 1.5 0.5 1 Light \"PxrDiskLight\" \"l\" \"float "
      "intensity\" [1] AttributeEnd\n";
  RenderRequest a, b;
  a.rib = whitePlane(askew, unbiased(0, "\"int numLightSamples\" [4]"));
  b.rib = whitePlane(askew, unbiased(0, "\"int numLightSamples\" [0]"));
  EXPECT_SAME_MEAN(overSeeds(a, 32), overSeeds(b, 32), 0.003);
}

// Howell, A Catalog of Radiation Heat Transfer Configuration Factors, B-30: from an element whose normal meets the
// end of a cylinder at a right angle to its axis; radius r, length l, distance h from the axis.
double viewFactorOfCylinder(double r, double l, double h) {
  const double L = l / r, H = h / r, X = (1 + H) * (1 + H) + L * L, Y = (1 - H) * (1 - H) + L * L;
  return std::atan(L / std::sqrt(H * H - 1)) / (kPi * H) +
         L / kPi *
             ((X - 2 * H) / (H * std::sqrt(X * Y)) * std::atan(std::sqrt(X * (H - 1) / (Y * (H + 1)))) -
              std::atan(std::sqrt((H - 1) / (H + 1))) / H);
}

TEST(Irradiance, OfACylinder) {
  for (const double distance : {0.6, 3.0}) {
    const double e = kPi * 2 * viewFactorOfCylinder(0.5, 0.5, distance);
    const std::string light = kUnseen + "Translate 0 0 " + std::to_string(1 - distance) +
                              " Light \"PxrCylinderLight\" \"l\" \"float intensity\" [1] AttributeEnd\n";
    expectIrradiance(light, e, "cylinder");
    if (distance < 1) expectByBxdfSamplesAlone(light, e, "cylinder");
  }
}

TEST(Irradiance, OfMeshes) {
  const double a = 0.5, h = 0.7, q = std::sqrt(a * a + h * h), square = 4 * a / q * std::atan(a / q);
  const std::string place = kUnseen + "Translate 0 0 0.3 ",
                    mesh = "Light \"PxrMeshLight\" \"l\" \"float intensity\" [1]\n";
  const std::string
      points = " \"P\" [-0.5 -0.5 0  0.5 -0.5 0  0.5 0.5 0  -0.5 0.5 0]\n",
      grid =
          "PointsPolygons [4 3 3] [0 1 4 3  1 2 4  4 2 5] \"P\" [-0.5 -0.5 0  0 -0.5 0  0.5 -0.5 0  -0.5 0.5 0  0 "
          "0.5 0  0.5 0.5 0]\n";
  expectIrradiance(place + mesh + "Polygon" + points + "AttributeEnd\n", square, "square");
  expectByBxdfSamplesAlone(place + mesh + "Polygon" + points + "AttributeEnd\n", square, "square");
  expectIrradiance(place + mesh + grid + "AttributeEnd\n", square, "square of three faces");
  // a mirroring transform leaves the outside outside; the other orientation emits the other way
  expectIrradiance(place + "Scale -1 1 1 " + mesh + "Polygon" + points + "AttributeEnd\n", square, "mirrored square");
  RenderRequest dark;
  dark.rib = whitePlane(place + "ReverseOrientation " + mesh + "Polygon" + points + "AttributeEnd\n", unbiased(0));
  EXPECT_EQ(overSeeds(dark, 1).mean(), 0);
  // a sphere as geometry, from outside: E = pi L (r / d)^2, less what its flat triangles lose
  const double ball = kPi * 0.09 / (0.49 * 1.0);
  const std::string sphere = place + mesh + "Sphere 0.3 -0.3 0.3 360 AttributeEnd\n";
  expectIrradiance(sphere, ball, "sphere of triangles");
  // an object is the light's shape as what is in it would be, objects within it too, with either of its places
  const std::string object = "ObjectBegin \"card\" Translate 0 0 0.1 Polygon" + std::string(points) +
                             "ObjectEnd\nObjectBegin \"in\" Translate 0 0 0.1 ObjectInstance \"card\" ObjectEnd\n";
  expectIrradiance(object + kUnseen + "Translate 0 0 0.2 " + mesh + "ObjectInstance \"card\" AttributeEnd\n", square,
                   "square in an object");
  expectIrradiance(object + kUnseen + mesh + "Translate 0 0 0.1 ObjectInstance \"in\" AttributeEnd\n", square,
                   "square in an object in an object");
  expectIrradiance(object + "ObjectBegin \"lamp\" AttributeBegin " + mesh +
                       "ObjectInstance \"card\" AttributeEnd ObjectEnd\n" + kUnseen +
                       "Translate 0 0 0.2 ObjectInstance \"lamp\" AttributeEnd\n",
                   square, "lamp in an object");
  expectIrradiance(place + mesh + "Polygon" + points + "AttributeEnd\n" + object + kUnseen + "Translate 0 0 0.2 " +
                       mesh + "ObjectInstance \"card\" AttributeEnd\n" + kUnseen + "Translate 100 0 0 " + mesh +
                       "ObjectInstance \"card\" AttributeEnd\n",
                   2 * square, "lamps of one object");
  // which side shines is said where the object is placed, of that place alone
  const std::string turned =
      kUnseen + "Translate 0 0 0.1 " + mesh + "ReverseOrientation ObjectInstance \"card\" AttributeEnd\n";
  dark.rib = whitePlane(object + turned, unbiased(0));
  EXPECT_EQ(overSeeds(dark, 1).mean(), 0);
  expectIrradiance(object + turned + kUnseen + "Translate 0 0 0.2 " + mesh + "ObjectInstance \"card\" AttributeEnd\n",
                   square, "one of two places of an object shines this way");
}

TEST(Irradiance, LightsRunNoPatternsAndSaySo) {
  for (const char* light : {"PxrDomeLight", "PxrRectLight"}) {
    SCOPED_TRACE(light);
    RenderRequest q;
    q.rib = whitePlane(kUnseen + "Pattern \"PxrToFloat3\" \"q\" \"float input\" [.25]\nLight \"" + light +
                           "\" \"l\" \"reference color lightColor\" [\"q:resultRGB\"]\nAttributeEnd\n",
                       unbiased(0));
    SceneRender r(q);
    ASSERT_TRUE(r.ok());
    EXPECT_EQ(timesSaid(r, {"LIGHT-CONNECTION", "lightColor"}), 1);
  }
}

TEST(Irradiance, OfOldAreaLights) {
  // real geometry emits from its outside, and its power does not grow with its size unless the file says so
  const std::string begin =
      kUnseen + "AreaLightSource \"PxrStdAreaLight\" \"old\" \"int areaNormalize\" [0]\nTranslate 0 0 ";
  expectIrradiance(begin + "-1\nDisk 0 0.5 360\nAttributeEnd\n", kPi * 0.25 / 4.25, "disk of an old kind");
  expectIrradiance(begin + "-1\nSphere 0.5 -0.5 0.5 360\nAttributeEnd\n", kPi * 0.25 / 4, "sphere of an old kind");
  expectIrradiance(begin + "-1\nScale 1 1 -1 Geometry \"rectlight\"\nAttributeEnd\n",
                   1.0 / 4.25 * std::sqrt(4.25) * 2 * std::atan(0.5 / std::sqrt(4.25)), "rectangle of an old kind");
  expectIrradiance(begin + "-1\nScale 1 1 -1 Geometry \"disklight\"\nAttributeEnd\n", kPi * 0.25 / 4.25,
                   "disk of an old kind by its name");
  const std::string scaled =
      kUnseen + "AreaLightSource \"PxrStdAreaLight\" \"old\"\nTranslate 0 0 -1\nDisk 0 0.5 360\nAttributeEnd\n";
  expectIrradiance(scaled, 1 / 4.25, "disk of an old kind, its power of its own");
}

TEST(Irradiance, OfADistantLight) {
  for (const double angle : {0.53, 20.0})
    for (const double tilt : {0.0, 60.0}) {
      const double s = std::sin(angle / 2 * kPi / 180), e = 100 * kPi * s * s * std::cos(tilt * kPi / 180);
      const std::string light =
          "AttributeBegin Rotate " + std::to_string(tilt) +
          " 1 0 0 Light \"PxrDistantLight\" \"l\" \"float intensity\" [100] \"float angleExtent\" [" +
          std::to_string(angle) + "] AttributeEnd\n";
      expectIrradiance(light, e, "distant light");
    }
}

TEST(Irradiance, OfADome) {
  const std::string light = "Light \"PxrDomeLight\" \"l\" \"float intensity\" [1]\n";
  expectIrradiance(light, kPi, "dome");
  expectIrradiance(light, kPi, "dome on a tilted plane", "Rotate 50 0 1 0");
  expectByBxdfSamplesAlone(light, kPi, "dome");
}

TEST(Irradiance, OfSeveralLightsIsTheSum) {
  const double a = 0.5, h = 2, q = std::sqrt(a * a + h * h);
  const std::string lights =
      "AttributeBegin Translate 0 0 -1 Light \"PxrRectLight\" \"r\" \"float intensity\" [1] AttributeEnd\n"
      "AttributeBegin Translate 0 0 -3 Light \"PxrSphereLight\" \"s\" \"float intensity\" [10] AttributeEnd\n"
      "Light \"PxrDomeLight\" \"d\" \"float intensity\" [0.1]\n"
      "Light \"PxrDistantLight\" \"f\" \"float intensity\" [50] \"float angleExtent\" [5]\n";
  const double s = std::sin(2.5 * kPi / 180);
  // no light blocks another: each is seen through the others
  const double e = 4 * a / q * std::atan(a / q) + 10 * kPi * 0.25 / 16 + 0.1 * kPi + 50 * kPi * s * s;
  expectIrradiance(lights, e, "four lights");
}

// The box of the gallery without its glass ball: direct light only, by both integrators.
RenderRequest box(const std::string& integrator, const std::string& more = "") {
  RenderRequest r;
  r.rib =
      "Format 32 32 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [16]\nProjection "
      "\"perspective\" \"fov\" [40]\n"
      "Translate 0 -1 3.35\n" +
      integrator + R"(WorldBegin
AttributeBegin
ConcatTransform [1.3 0 0 0  0 0 0.7 0  0 -1 0 0  0 1.9 1 1]
Light "PxrRectLight" "ceiling" "float intensity" [9]
AttributeEnd
)" + more +
      R"(
Bxdf "PxrDiffuse" "white" "color diffuseColor" [0.7 0.6 0.5]
PointsPolygons [4 4 4 4 4] [0 1 2 3  4 7 6 5  3 2 6 7  0 3 7 4  1 5 6 2]
  "vertex point P" [-1.2 0 0  1.2 0 0  1.2 0 2  -1.2 0 2  -1.2 2 0  1.2 2 0  1.2 2 2  -1.2 2 2]
AttributeBegin
Bxdf "PxrSurface" "metal" "color diffuseColor" [0.2 0.1 0.1] "color specularFaceColor" [0.6 0.6 0.6] "color specularEdgeColor" [1 1 1] "float specularRoughness" [0.3]
Translate 0.4 0.5 1
Sphere 0.5 -0.5 0.5 360
AttributeEnd
WorldEnd
)";
  return r;
}

TEST(Agreement, DirectLightingIsThePathTracerWithoutBounces) {
  EXPECT_SAME_MEAN(overSeeds(box("Integrator \"PxrDirectLighting\" \"i\"\n"), 12), overSeeds(box(unbiased(0)), 12),
                   0.003);
}

TEST(Agreement, NumbersOfSamplesChangeNoMean) {
  const auto one = overSeeds(box(unbiased(3)), 12);
  EXPECT_SAME_MEAN(one, overSeeds(box(unbiased(3, "\"int numLightSamples\" [4]")), 12), 0.003);
  EXPECT_SAME_MEAN(one, overSeeds(box(unbiased(3, "\"int numIndirectSamples\" [3]")), 12), 0.003);
  EXPECT_SAME_MEAN(one, overSeeds(box(unbiased(3, "\"int numIndirectSamples\" [2] \"int numLightSamples\" [2]")), 12),
                   0.003);
}

TEST(Agreement, NumbersOfIndirectSamplesChangeNoMeanBehindGlass) {
  // paths of one camera hit must not share what they carry: media, lights linked, the hit itself
  const std::string ball = R"(AttributeBegin
Bxdf "PxrSurface" "glass" "float diffuseGain" [0] "float refractionGain" [1] "float reflectionGain" [1] "float glassRoughness" [0.2]
  "color extinction" [1 1 1]
Translate -0.4 0.6 0.5
Sphere 0.5 -0.5 0.5 360
AttributeEnd)";
  const auto one = overSeeds(box(unbiased(4), ball), 16);
  EXPECT_SAME_MEAN(one, overSeeds(box(unbiased(4, "\"int numIndirectSamples\" [3]"), ball), 16), 0.004);
}

// A light's diffuse and specular factors weigh what both techniques find alike.
TEST(Agreement, LightFactorsHoldForBothTechniques) {
  const auto with = [](const char* factors, const char* samples) {
    RenderRequest r = box(unbiased(0, samples));
    r.rib.insert(r.rib.find("[9]") + 3, factors);
    return overSeeds(r, 16);
  };
  for (const char* factors :
       {" \"float specular\" [0]", " \"float diffuse\" [0]", " \"float diffuse\" [0.5] \"float specular\" [2]"})
    EXPECT_SAME_MEAN(with(factors, ""), with(factors, "\"int numLightSamples\" [0] \"int numIndirectSamples\" [4]"),
                     0.01);
}

TEST(Agreement, RouletteChangesNoMean) {
  const auto off = overSeeds(box(unbiased(8)), 16);
  EXPECT_SAME_MEAN(off, overSeeds(box(unbiased(8, "\"int rouletteDepth\" [1]")), 16), 0.003);
  std::string on = unbiased(8);
  on.replace(on.find("\"float rouletteThreshold\" [0]"), 29,
             "\"float rouletteThreshold\" [1] \"int rouletteDepth\" [1]");
  EXPECT_SAME_MEAN(off, overSeeds(box(on), 16), 0.003);
}

TEST(Agreement, ClampsOnlyDarken) {
  std::string clamped = unbiased(4);
  clamped.replace(clamped.find("[1e30]"), 6, "[0.05]");
  const auto off = overSeeds(box(unbiased(4)), 8), on = overSeeds(box(clamped), 8);
  EXPECT_LT(on.mean(), off.mean() - 4 * (on.standardError() + off.standardError()));
  // a clamp that no contribution reaches changes nothing, bit for bit
  std::string idle = unbiased(4);
  idle.replace(idle.find("[1e30]"), 6, "[1e6]");
  SceneRender a(box(unbiased(4))), b(box(idle));
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(hashOf(a.film()), hashOf(b.film()));
}

// Lights move and turn with the shutter; that they keep their size is told where it shows.
TEST(DirectLight, LightsThatChangeTheirSizeAreTold) {
  const auto messages = [](const char* shutter, const char* first, const char* second) {
    RenderRequest r;
    r.rib = orthographic(4, 1, 4) + shutter + "WorldBegin\nAttributeBegin MotionBegin [0 1] " + first + " " + second +
            " MotionEnd Light \"PxrSphereLight\" \"lamp\"\nAttributeEnd\nSphere 0.4 -0.4 0.4 360\nWorldEnd\n";
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    return timesSaid(render, {"LIGHT-MOTION"});
  };
  EXPECT_EQ(messages("Shutter 0 1\n", "Scale 1 1 1", "Scale 1 2 1"), 1);
  EXPECT_EQ(messages("Shutter 0 1\n", "Scale 1 1 1", "Scale -0.5 1 1"), 1);
  EXPECT_EQ(messages("Shutter 0 1\n", "Translate 0 0 0", "Translate 0 1 0"), 0);
  EXPECT_EQ(messages("Shutter 0 1\n", "Rotate 0 0 1 0", "Rotate 720 0 1 0"), 0);
  EXPECT_EQ(messages("", "Scale 1 1 1", "Scale 1 2 1"), 0);
}

// E of a square of side 1 that emits 1, seen from a distance h over its centre.
double ofSquare(double h) {
  const double q = std::sqrt(0.25 + h * h);
  return 2 / q * std::atan(0.5 / q);
}

// What lights of geometry lack is told, and the picture says what stands in.
TEST(DirectLight, GeometryThatLightsDoNotFollowIsTold) {
  const std::string square = "Polygon \"P\" [-.5 -.5 0  .5 -.5 0  .5 .5 0  -.5 .5 0]\n";
  const auto radiance = [](const std::string& geometry, const char* what) {
    RenderRequest r;
    r.rib = "Shutter 0 1\n" + whitePlane(
                                  "AttributeBegin Attribute \"visibility\" \"int camera\" [0] Light "
                                  "\"PxrMeshLight\" \"m\" \"float intensity\" [1]\n" +
                                      geometry + "AttributeEnd\n",
                                  unbiased(0));
    SceneRender render(r);
    EXPECT_TRUE(render.ok()) << geometry;
    const auto told = [&](const std::string& m) {
      return m.find("LIGHT-GEOMETRY") != std::string::npos && m.find(what) != std::string::npos;
    };
    EXPECT_TRUE(std::any_of(render.messages().begin(), render.messages().end(), told)) << geometry;
    return overPixels(render.channel("Ci")).mean();
  };
  for (const char* strand : {"Points \"P\" [0 0 0] \"constant float constantwidth\" [1]\n",
                             "Curves \"linear\" [2] \"nonperiodic\" \"P\" [0 0 0 0 1 0] \"constantwidth\" [.1]\n"})
    EXPECT_EQ(radiance(strand, "surfaces"), 0);
  const double inSolid = radiance("SolidBegin \"primitive\" " + square + "SolidEnd\n", "solid");
  EXPECT_NEAR(inSolid, ofSquare(1) / kPi, 0.01 * ofSquare(1) / kPi);
}

// A square goes away from what it lights while the shutter is open, displaced besides or not, and nothing is told.
TEST(DirectLight, DeformingGeometryShinesFromWhereItIs) {
  const auto radiance = [](const std::string& shutter, const std::string& attributes) {
    RenderRequest r;
    r.rib = shutter + whitePlane(
                          "AttributeBegin Attribute \"visibility\" \"int camera\" [0] Light "
                          "\"PxrMeshLight\" \"m\" \"float intensity\" [1]\n" +
                              attributes +
                              "MotionBegin [0 1] Polygon \"P\" [-.5 -.5 0  .5 -.5 0  .5 .5 0  -.5 .5 0]\n"
                              "Polygon \"P\" [-.5 -.5 -1  .5 -.5 -1  .5 .5 -1  -.5 .5 -1] MotionEnd\nAttributeEnd\n",
                          unbiased(0));
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    for (const std::string& m : render.messages()) EXPECT_EQ(m.find("LIGHT-GEOMETRY"), std::string::npos) << m;
    return overPixels(render.channel("Ci")).mean();
  };
  const auto mean = [](double from, double to) {
    double sum = 0;
    for (int i = 0; i < 1000; ++i) sum += ofSquare(from + (to - from) * (i + 0.5) / 1000) / 1000;
    return sum / kPi;
  };
  EXPECT_NEAR(radiance("Shutter 0 1\n", ""), mean(1, 2), 0.01 * mean(1, 2));
  EXPECT_NEAR(radiance("Shutter 0.5 1\n", ""), mean(1.5, 2), 0.01 * mean(1.5, 2));
  EXPECT_NEAR(radiance("Shutter 0.25 0.25\n", ""), mean(1.25, 1.25), 0.01 * mean(1.25, 1.25));
  EXPECT_NEAR(radiance("Shutter 0 1\n",
                       "Attribute \"displacementbound\" \"float sphere\" [1]\n"
                       "Displace \"PxrDisplace\" \"d\" \"vector dispVector\" [0 0 -0.5] \"float dispScalar\" [0]\n"),
              mean(1.5, 2.5), 0.01 * mean(1.5, 2.5));
}

// A square goes away from what it lights, and nothing is told.
TEST(DirectLight, DisplacedGeometryShinesFromWhereItGoes) {
  const auto radiance = [](const std::string& attributes, const std::string& corners) {
    RenderRequest r;
    r.rib = whitePlane(
        "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\n"
        "Light \"PxrMeshLight\" \"m\" \"float intensity\" [1]\n" +
            attributes + "Polygon \"P\" [" + corners + "]\nAttributeEnd\n",
        unbiased(0));
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    for (const std::string& m : render.messages()) EXPECT_EQ(m.find("LIGHT-GEOMETRY"), std::string::npos) << m;
    return overPixels(render.channel("Ci")).mean();
  };
  const std::string displaced =
      "Attribute \"displacementbound\" \"float sphere\" [1]\n"
      "Displace \"PxrDisplace\" \"d\" \"vector dispVector\" [0 0 -0.5] \"float dispScalar\" [0]\n";
  const double q = std::sqrt(0.25 + 1.5 * 1.5), away = 2 / q * std::atan(0.5 / q) / kPi;  // of a square of side 1
  EXPECT_NEAR(radiance(displaced, "-.5 -.5 0  .5 -.5 0  .5 .5 0  -.5 .5 0"), away, 0.01 * away);
  EXPECT_NEAR(radiance("", "-.5 -.5 -.5  .5 -.5 -.5  .5 .5 -.5  -.5 .5 -.5"), away, 0.01 * away);
  // surfaces that are not to be displaced are none here either
  const double r = std::sqrt(0.25 + 1), stays = 2 / r * std::atan(0.5 / r) / kPi;
  EXPECT_NEAR(radiance("Attribute \"trace\" \"int displacements\" [0]\n" + displaced,
                       "-.5 -.5 0  .5 -.5 0  .5 .5 0  -.5 .5 0"),
              stays, 0.01 * stays);
}

}  // namespace
}  // namespace kinora::tests
