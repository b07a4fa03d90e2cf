// Displacement from the scene to the picture: displaced surfaces against those that they are, on every primitive; what
// holds for pictures in general (threads, widths); and what is told of what cannot be done.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "image/read_write.h"
#include "tests/support/render_scene.h"

namespace kinora::tests {
namespace {

constexpr const char* kWorld = R"(
Format 48 48 1
PixelFilter "box" 1 1
Hider "raytrace" "int maxsamples" [16]
Integrator "PxrPathTracer" "i" "int maxIndirectBounces" [1]
Projection "perspective" "fov" [40]
Shutter 0 1
Translate 0 0 5
WorldBegin
AttributeBegin
Attribute "visibility" "int camera" [0]
Light "PxrDomeLight" "sky"
AttributeEnd
AttributeBegin
Rotate 40 0 1 0
Rotate 30 1 0 0
Light "PxrDistantLight" "sun" "float intensity" [10000]
AttributeEnd
Bxdf "PxrDiffuse" "m" "color diffuseColor" [.6 .6 .6]
)";

RenderRequest requestOf(const std::string& objects, const std::string& channels = "Ci,a") {
  RenderRequest r;
  r.rib = kWorld + objects + "\nWorldEnd\n";
  r.channels = channels;
  return r;
}

struct Difference {
  double mean = 0, most = 0;
};
Difference between(SceneRender& a, SceneRender& b, const char* channel) {
  const image::Image x = a.channel(channel), y = b.channel(channel);
  Difference d;
  for (size_t i = 0; i < x.pixels.size(); ++i) {
    const double e = std::fabs(double(x.pixels[i]) - double(y.pixels[i]));
    d.mean += e / double(x.pixels.size());
    d.most = std::max(d.most, e);
  }
  return d;
}

std::string byDistance(double d) {
  return "Displace \"PxrDisplace\" \"d\" \"float dispAmount\" [" + std::to_string(d) + "] \"float dispScalar\" [1]\n";
}

// The same samples of nearly the same surface: what differs is a share of silhouettes.
void expectSame(const std::string& displaced, const std::string& as) {
  SceneRender a(requestOf(displaced, "Ci,a,z,Nn")), b(requestOf(as, "Ci,a,z,Nn"));
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_TRUE(a.messages().empty()) << a.messages()[0];
  EXPECT_GT(a.renderer().statistics().micropolygons, 500u);
  EXPECT_LT(between(a, b, "a").mean, 1e-3) << displaced;
  EXPECT_LT(between(a, b, "Nn").mean, 3e-3) << displaced;
  EXPECT_LT(between(a, b, "Ci").mean, 5e-3) << displaced;
}

TEST(DisplacedSurfaces, ByADistanceAreTheirLargerSelves) {
  expectSame(byDistance(0.4) + "Sphere 1 -1 1 360", "Sphere 1.4 -1.4 1.4 360");
  expectSame(byDistance(0.2) + "Rotate 50 1 0.3 0\nTorus 1 0.3 0 360 360",
             "Rotate 50 1 0.3 0\nTorus 1 0.5 0 360 360");
  expectSame(byDistance(-0.3) + "Rotate 90 1 0 0\nCylinder 1.3 -1 1 360", "Rotate 90 1 0 0\nCylinder 1 -1 1 360");
  // the object's own units: half of them are seen
  expectSame("Scale .5 .5 .5\n" + byDistance(0.4) + "Sphere 1.6 -1.6 1.6 360", "Sphere 1 -1 1 360");
}

TEST(DisplacedSurfaces, StayWhereTheAttributeSaysSo) {
  const std::string still = "Attribute \"trace\" \"int displacements\" [0]\n", moved = byDistance(0.4);
  for (const std::string& said : {still + moved, moved + still}) {
    SceneRender a(requestOf(said + "Sphere 1 -1 1 360")), b(requestOf("Sphere 1 -1 1 360"));
    ASSERT_TRUE(a.ok() && b.ok());
    EXPECT_TRUE(a.messages().empty()) << a.messages()[0];
    EXPECT_EQ(between(a, b, "a").mean, 0) << said;
  }
  // each instance of an object by its own
  const auto two = [&](const std::string& left, const std::string& right) {
    return SceneRender(
        requestOf("ObjectBegin \"ball\" Sphere 0.5 -0.5 0.5 360 ObjectEnd\nAttributeBegin Translate -1 0 0 " + left +
                  "ObjectInstance \"ball\" AttributeEnd\nTranslate 1 0 0 " + right + "ObjectInstance \"ball\""));
  };
  SceneRender a = two(byDistance(0.3) + still, byDistance(0.3)), b = two("", byDistance(0.3));
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(between(a, b, "a").mean, 0);
  SceneRender both = two(byDistance(0.3), byDistance(0.3));
  EXPECT_GT(between(a, both, "a").mean, 0.01);
}

TEST(DisplacedSurfaces, OfEveryKindMoveByAVector) {
  const std::string by = "Displace \"PxrDisplace\" \"d\" \"vector dispVector\" [.3 .2 -.5]\n";
  const std::string kinds[] = {
      "PointsPolygons [4 3] [0 1 2 3 1 4 2] \"P\" [-1 -1 0 0 -1 0 0 1 0 -1 1 0 1 0 .5]",
      "SubdivisionMesh \"catmull-clark\" [4 4] [0 1 2 3 1 4 5 2] [\"interpolateboundary\"] [1 0] [2] [] "
      "\"P\" [-1 -1 0 0 -1 .4 0 1 .2 -1 1 0 1 -1 0 1 1 .5]",
      "SubdivisionMesh \"loop\" [3 3] [0 1 2 0 2 3] [\"interpolateboundary\" \"corner\"] [1 0 4 1] [2 0 1 2 3] [9] "
      "\"P\" [-1 -1 0 1 -1 .4 1 1 .2 -1 1 0]",
      "Patch \"bilinear\" \"P\" [-1 -1 0 1 -1 .5 -1 1 0 1 1 -.5]",
      "Patch \"bicubic\" \"P\" [-1 -1 0 -.3 -1 .4 .3 -1 .4 1 -1 0 -1 -.3 .3 -.3 -.3 1 .3 -.3 1 1 -.3 .3 "
      "-1 .3 .3 -.3 .3 1 .3 .3 1 1 .3 .3 -1 1 0 -.3 1 .4 .3 1 .4 1 1 0]",
      "NuPatch 3 3 [0 0 0 1 1 1] 0 1 3 3 [0 0 0 1 1 1] 0 1 "
      "\"P\" [-1 -1 0 0 -1 .5 1 -1 0 -1 0 .5 0 0 1 1 0 .5 -1 1 0 0 1 .5 1 1 0]",
      "Disk 0.2 1 360",
      "Paraboloid 1 0 1 360",
      "Geometry \"cube\"",
      "Blobby 1 [1001 0] [.8 0 0 0 0 .8 0 0 0 0 .8 0 0 0 0 1] [\"\"]",
  };
  for (const std::string& kind : kinds)
    expectSame("Rotate 40 1 0 0\n" + by + kind,
               "Rotate 40 1 0 0\nTranslate .3 .2 -.5\nAttribute \"dice\" \"float micropolygonlength\" [.3]\n" + kind);
}

// What lies in the object's space lies where the surface was.
TEST(DisplacedSurfaces, KeepWhatIsPaintedOnThem) {
  const auto of = [](const std::string& displacement, float radius, const std::string& variable) {
    RenderRequest r =
        requestOf("Rotate 40 1 1 0\nScale .5 .5 .5\nTranslate 1 0 0\n" + displacement +
                  "Pattern \"PxrVariable\" \"o\" \"string variable\" [\"" + variable +
                  "\"]\nBxdf \"PxrConstant\" \"m\" \"reference color emitColor\" [\"o:resultRGB\"]\nSphere " +
                  std::to_string(radius) + " -" + std::to_string(radius) + " " + std::to_string(radius) + " 360");
    return std::make_unique<SceneRender>(r);
  };
  for (const std::string variable : {"st", "Po"}) {
    const auto moved = of(byDistance(0.4), 1.6f, variable), larger = of("", 2, variable);
    image::Image a = moved->channel("Ci");
    const image::Image b = larger->channel("Ci"), seen = larger->channel("a");
    double most = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i) {
      const double scale = variable == "Po" ? 0.8 : 1;  // the same direction on the smaller sphere
      if (seen.pixels[i / 3] == 1) most = std::max(most, std::fabs(a.pixels[i] - scale * b.pixels[i]));
    }
    // at the seam of st a pixel has both ends
    EXPECT_LT(most, variable == "Po" ? 0.02 : 1.) << variable;
    EXPECT_LT(between(*moved, *larger, "Ci").mean, variable == "st" ? 2e-3 : 0.2) << variable;
  }
}

// A picture of waves as heights: bump of the material, or displacement. While they are small they look alike from the
// front, the less so the higher they are.
TEST(DisplacedSurfaces, BumpAndDisplacementAgreeWhereTheyAreSmall) {
  constexpr int kSize = 128;
  image::Image waves({0, 0, kSize, kSize}, {{"R", image::StoredType::Float}});
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      waves.pixels[size_t(y) * kSize + size_t(x)] =
          float(0.5 + 0.5 * std::sin(0.049087385 * 4 * (x + 0.5)) * std::cos(0.049087385 * 3 * (y + 0.5)));
  const std::string file = (std::filesystem::temp_directory_path() / "kinora_waves.exr").string();
  ASSERT_TRUE(image::write(file, waves).ok());
  const std::string plane = "Patch \"bilinear\" \"P\" [2 -2 0 -2 -2 0 2 2 0 -2 2 0]";
  // the sun alone, whose light is known without noise
  const auto lit = [](const std::string& objects) {
    RenderRequest r = requestOf(objects, "Ci");
    r.rib.replace(r.rib.find("\"sky\""), 5, "\"sky\" \"float intensity\" [0]");
    r.rib.replace(r.rib.find("[1]\n"), 3, "[0]");
    r.rib.replace(r.rib.find("Format 48 48 1"), 14, "Format 144 144 1");
    r.rib.replace(r.rib.find("\"int maxsamples\" [16]"), 21, "\"int maxsamples\" [4]");
    return r;
  };
  SceneRender flat(lit(plane));
  double before = 1;
  for (const double height : {.2, .05, .01}) {
    const std::string h = std::to_string(height);
    SceneRender moved(lit(
        "Attribute \"dice\" \"float micropolygonlength\" [.5]\nPattern \"PxrTexture\" \"t\" \"string filename\" [\"" +
        file + "\"]\nDisplace \"PxrDisplace\" \"d\" \"float dispAmount\" [" + h +
        "] \"reference float dispScalar\" [\"t:resultR\"]\n" + plane));
    SceneRender bent(lit("Pattern \"PxrBump\" \"b\" \"float scale\" [" + h + "] \"string filename\" [\"" + file +
                         "\"]\nBxdf \"PxrDiffuse\" \"m\" \"color diffuseColor\" [.6 .6 .6] "
                         "\"reference normal bumpNormal\" [\"b:resultN\"]\n" +
                         plane));
    ASSERT_TRUE(moved.ok() && bent.ok() && flat.ok());
    EXPECT_TRUE(moved.messages().empty()) << moved.messages()[0];
    const double relief = between(bent, flat, "Ci").mean, off = between(moved, bent, "Ci").mean / relief;
    EXPECT_GT(relief, 0.05 * height);
    EXPECT_LT(off, before);
    before = off;
  }
  EXPECT_LT(before, 0.1);
  std::filesystem::remove(file);
}

TEST(DisplacedSurfaces, LengthsAndVectorsHaveSpaces) {
  // the object is half as large and turned: a unit of the world is two of its own
  const std::string turned = "Rotate 30 1 1 0\nScale .5 .5 .5\n", ball = "Sphere 1 -1 1 360";
  const auto by = [](const std::string& parameters, const std::string& output) {
    return "Pattern \"PxrDispTransform\" \"t\" " + parameters + "\nDisplace \"PxrDisplace\" \"d\" \"reference " +
           (output == "resultF" ? "float dispScalar" : "vector dispVector") + "\" [\"t:" + output + "\"]\n";
  };
  const std::string world = " \"string dispScaleSpace\" [\"world\"]";
  expectSame(turned + by("\"float dispScalar\" [.3]", "resultF") + ball, turned + "Sphere 1.3 -1.3 1.3 360");
  expectSame(turned + by("\"float dispScalar\" [.3]" + world, "resultF") + ball, turned + "Sphere 1.6 -1.6 1.6 360");
  const std::string vector = "\"int dispType\" [2] \"int vectorSpace\" [1] \"vector dispVector\" [.5 .2 0]" + world;
  expectSame(turned + by(vector, "resultXYZ") + ball, "Translate .5 .2 0\n" + turned + ball);
  const std::string up =
      "\"float dispScalar\" [.5] \"int useDispDirection\" [1] \"vector dispDirection\" [0 3 0] "
      "\"string dispDirectionSpace\" [\"world\"]" +
      world;
  expectSame(turned + by(up, "resultXYZ") + ball, "Translate 0 .5 0\n" + turned + ball);
}

TEST(DisplacedSurfaces, HoldTightWhereFacesMeet) {
  // closed bodies around the eye and around a white light: what comes through a crack is bright
  const std::string noise =
      "Pattern \"PxrVoronoise\" \"v\" \"float frequency\" [5]\n"
      "Displace \"PxrDisplace\" \"d\" \"float dispAmount\" [.5] \"reference float dispScalar\" [\"v:resultF\"]\n"
      "Bxdf \"PxrBlack\" \"k\"\n";
  const std::string bodies[] = {
      "PointsPolygons [4 4 4 4 4 4] [0 2 3 1 4 5 7 6 0 1 5 4 2 6 7 3 0 4 6 2 1 3 7 5] "
      "\"P\" [-1 -1 -1 1 -1 -1 -1 1 -1 1 1 -1 -1 -1 1 1 -1 1 -1 1 1 1 1 1]",
      "PointsPolygons [3 3 3 3] [0 2 1 0 1 3 1 2 3 2 0 3] \"P\" [-1 -1 -1 1 -1 -1 0 1 -1 0 0 1]",
      "SubdivisionMesh \"catmull-clark\" [3 3 3 3] [0 2 1 0 1 3 1 2 3 2 0 3] "
      "\"P\" [-6 -6 -4 6 -6 -4 0 6 -4 0 0 8]",
      "Sphere 1 -1 1 360",
      "Geometry \"cube\"",
  };
  for (const std::string& body : bodies) {
    RenderRequest r = requestOf(noise + body);
    const size_t eye = r.rib.find("Translate 0 0 5");
    r.rib.replace(eye, 15, "Translate 0 0 0.01");
    r.rib.replace(r.rib.find("Projection \"perspective\" \"fov\" [40]"), 35, "Projection \"PxrSphereCamera\"");
    r.rib.replace(r.rib.find("[0]\nLight \"PxrDomeLight"), 3, "[1]");
    r.rib.replace(r.rib.find("\"int maxsamples\" [16]"), 21, "\"int maxsamples\" [512]");
    SceneRender inside(r);
    ASSERT_TRUE(inside.ok());
    double most = 0;
    for (const float x : inside.channel("Ci").pixels) most = std::max(most, double(x));
    EXPECT_EQ(most, 0) << body;
  }
}

TEST(DisplacedSurfaces, AreTheSameBitsForAnyThreadsAndWidths) {
  const std::string objects =
      "Pattern \"PxrFractal\" \"f\" \"float frequency\" [2]\n"
      "Displace \"PxrDisplace\" \"d\" \"float dispAmount\" [.3] \"reference float dispScalar\" [\"f:resultF\"]\n"
      "Sphere 1 -1 1 360\nTranslate 0 -1 0\nPointsPolygons [4] [0 1 2 3] \"P\" [-2 0 -2 2 0 -2 2 0 2 -2 0 2]";
  RenderRequest request = requestOf(objects, kAllChannels);
  request.settings.width = 8;
  SceneRender usual(request);
  const uint64_t hash = hashOf(usual.film());
  for (const uint32_t width : {1u, 4u, 16u}) {
    request.settings.width = width;
    request.settings.threads = width == 4 ? 3 : 1;
    SceneRender other(request);
    EXPECT_EQ(hashOf(other.film()), hash) << width;
  }
}

TEST(DisplacedSurfaces, MoveAtEachKey) {
  // a plate that bends while the shutter is open, moved along itself by a vector
  const std::string keys =
      "MotionBegin [0 1]\nPatch \"bilinear\" \"P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]\n"
      "Patch \"bilinear\" \"P\" [-1 -1 0 1 -1 1 -1 1 1 1 1 0]\nMotionEnd";
  expectSame("Displace \"PxrDisplace\" \"d\" \"vector dispVector\" [.3 .2 -.5]\n" + keys,
             "AttributeBegin\nTranslate .3 .2 -.5\n" + keys + "\nAttributeEnd");
}

TEST(DisplacedSurfaces, InstancesShareTheirRelief) {
  const std::string object =
      "ObjectBegin \"o\"\nDisplace \"PxrDisplace\" \"d\" \"float dispScalar\" [.3]\nSphere .5 -.5 .5 "
      "360\nObjectEnd\n";
  const auto place = [](const std::string& what) {
    return "AttributeBegin\nTranslate -1 0 0\n" + what +
           "\nAttributeEnd\nAttributeBegin\nTranslate 1 0 0\nScale .5 .5 "
           ".5\n" +
           what + "\nAttributeEnd\n";
  };
  expectSame(object + place("ObjectInstance \"o\""), place("Sphere .8 -.8 .8 360"));
}

// Shaders move P in the world, plug-ins in the object.
TEST(DisplacedSurfaces, ByShadersOfTheShadingLanguage) {
  const auto folder = std::filesystem::temp_directory_path() / "kinora_displacements";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "grow.osl")
      << "displacement grow(float by = .4) {\n  if (by > 5) return;\n  P += by * N;\n}";
  std::ofstream(folder / "lift.osl")
      << "displacement lift(vector by = 0) { P += transform(\"object\", \"common\", by); }";
  std::ofstream(folder / "waves.osl") << "displacement waves(float by = 1) {\n  point o = transform(\"object\", P);\n"
                                         "  displace(\"object\", by * sin(3 * o[0]) * cos(3 * o[1]));\n}";
  std::ofstream(folder / "wave.osl")
      << "shader wave(output float height = 0) {\n  point o = transform(\"object\", P);\n"
         "  height = .2 * sin(3 * o[0]) * cos(3 * o[1]);\n}";
  std::ofstream(folder / "tilt.osl") << "displacement tilt(vector to = 0) { N = normalize(N + to); }";
  const std::string path = "Option \"searchpath\" \"string shader\" [\"" + folder.string() + "\"]\n";
  const auto expect = [&](const std::string& a, const std::string& b) {
    RenderRequest x = requestOf(a, "Ci,a,z,Nn"), y = requestOf(b, "Ci,a,z,Nn");
    x.rib = path + x.rib;
    y.rib = path + y.rib;
    SceneRender one(x), other(y);
    ASSERT_TRUE(one.ok() && other.ok());
    EXPECT_TRUE(one.messages().empty()) << one.messages()[0];
    EXPECT_LT(between(one, other, "a").mean, 1e-3) << a;
    EXPECT_LT(between(one, other, "Nn").mean, 3e-3) << a;
    EXPECT_LT(between(one, other, "Ci").mean, 5e-3) << a;
  };
  const std::string turned = "Rotate 30 1 1 0\nScale .5 .5 .5\n";
  expect("Displace \"grow\" \"d\"\nSphere 1 -1 1 360", "Sphere 1.4 -1.4 1.4 360");
  expect("Displace \"PxrOSL\" \"d\" \"string shader\" [\"grow\"] \"float by\" [.2]\nSphere 1 -1 1 360",
         "Sphere 1.2 -1.2 1.2 360");
  expect("Displace \"grow\" \"d\" \"float by\" [6]\nSphere 1 -1 1 360", "Sphere 1 -1 1 360");
  expect(turned + "Displace \"lift\" \"d\" \"vector by\" [.5 0 -1]\nSphere 1 -1 1 360",
         turned + "Translate .5 0 -1\nSphere 1 -1 1 360");
  const std::string plate = "Patch \"bilinear\" \"P\" [2 -2 0 -2 -2 0 2 2 0 -2 2 0]";
  expect(
      turned + "Displace \"waves\" \"d\" \"float by\" [.2]\n" + plate,
      turned +
          "Pattern \"wave\" \"w\"\nDisplace \"PxrDisplace\" \"d\" \"reference float dispScalar\" [\"w:height\"]\n" +
          plate);
  // N alone tilts what is seen, whatever its length and side
  RenderRequest tilted = requestOf("Displace \"tilt\" \"d\" \"vector to\" [.5 0 0]\n" + plate, "Ci,a,z,Nn"),
                flat = requestOf(plate, "Ci,a,z,Nn");
  tilted.rib = path + tilted.rib;
  SceneRender one(tilted), other(flat);
  EXPECT_TRUE(one.messages().empty()) << one.messages()[0];
  EXPECT_LT(between(one, other, "z").most, 1e-4);
  const image::Image n = one.channel("Nn");
  EXPECT_NEAR(n.pixels[0], 0.5 / std::sqrt(1.25), 1e-3);
  EXPECT_NEAR(n.pixels[2], -1 / std::sqrt(1.25), 1e-3);
  std::filesystem::remove_all(folder);
}

// What cannot be done is told, and the surface is where it is without.
TEST(DisplacedSurfaces, BadInputIsTold) {
  const std::string ball = "Sphere 1 -1 1 360";
  SceneRender plain(requestOf(ball));
  const auto expect = [&](const std::string& displacement, const std::string& object, const char* code) {
    SceneRender r(requestOf(displacement + object)), same(requestOf(object));
    EXPECT_TRUE(r.ok());
    if (*code)
      EXPECT_TRUE(says(r, code)) << displacement;
    else
      EXPECT_TRUE(r.messages().empty()) << r.messages()[0];
    EXPECT_LT(between(r, same, "Ci").mean, 2e-3) << displacement;
  };
  const std::string up = "Displace \"PxrDisplace\" \"d\" \"float dispScalar\" [.3]\n";
  expect("Displace \"PxrNoSuchDisplacement\" \"d\"\n", ball, "PLUGIN-MISSING");
  expect(up, "Curves \"linear\" [2] \"nonperiodic\" \"P\" [-1 0 0 1 0 0] \"constantwidth\" [.3]",
         "DISPLACEMENT-KIND");
  expect(up, "Points \"P\" [-1 0 0 1 0 0] \"constantwidth\" [.6]", "DISPLACEMENT-KIND");
  // 1e38 * 10 is no number; 1e20 is one that no ray could reach
  expect("Displace \"PxrDisplace\" \"d\" \"float dispAmount\" [10] \"float dispScalar\" [1e38]\n", ball,
         "DISPLACEMENT-NOT-FINITE");
  expect("Displace \"PxrDisplace\" \"d\" \"float dispScalar\" [1e20]\n", ball, "DISPLACEMENT-NOT-FINITE");
  expect("Displace \"PxrDisplace\" \"d\" \"int enabled\" [0] \"float dispScalar\" [1]\n", ball, "");
}

TEST(DisplacedSurfaces, BoundsAreCheckedAndNotObeyed) {
  const std::string ball = "Displace \"PxrDisplace\" \"d\" \"float dispScalar\" [.3]\nSphere 1 -1 1 360";
  SceneRender without(requestOf(ball));
  EXPECT_TRUE(without.messages().empty());
  const auto expect = [&](const std::string& bound, const char* what) {
    SceneRender r(requestOf("Attribute \"displacementbound\" " + bound + "\n" + ball));
    if (*what)
      EXPECT_TRUE(says(r, what)) << bound << (r.messages().empty() ? "" : r.messages()[0]);
    else
      EXPECT_TRUE(r.messages().empty()) << r.messages()[0];
    EXPECT_EQ(hashOf(r.film()), hashOf(without.film())) << bound;
  };
  expect("\"float sphere\" [.3]", "");
  expect("\"float sphere\" [.1] \"string coordinatesystem\" [\"object\"]", "3 times that");
  expect("\"float sphere\" [0]", "DISPLACEMENT-BOUND");
  expect("\"float sphere\" [-1]", "DISPLACEMENT-BOUND");
  SceneRender scaled(
      requestOf("Attribute \"displacementbound\" \"float sphere\" [.3] \"string coordinatesystem\" "
                "[\"world\"]\nScale 2 2 2\n" +
                ball));
  EXPECT_TRUE(says(scaled, "2 times that"));
}

// One surface for all instances: where scales differ and lengths are the world's it is told.
TEST(DisplacedSurfaces, ScalesOfInstancesThatDifferAreTold) {
  const auto told = [](const std::string& space, const std::string& scale) {
    SceneRender r(requestOf(
        "Pattern \"PxrDispTransform\" \"t\" \"float dispScalar\" [.1] \"string dispScaleSpace\" [\"" + space +
        "\"]\nDisplace \"PxrDisplace\" \"d\" \"reference float dispScalar\" [\"t:resultF\"]\n"
        "ObjectBegin \"o\"\nSphere .3 -.3 .3 360\nObjectEnd\nTranslate -.5 0 0\n"
        "ObjectInstance \"o\"\nTranslate 1 0 0\nScale " +
        scale + "\nObjectInstance \"o\""));
    EXPECT_TRUE(r.ok());
    return says(r, "DISPLACEMENT-SCALE");
  };
  EXPECT_TRUE(told("world", "2 2 2"));
  EXPECT_FALSE(told("world", "-1 1 1"));
  EXPECT_FALSE(told("object", "2 2 2"));
}

// Shaders reckon in any space: what they do tells.
TEST(DisplacedSurfaces, ShadersThatReckonInTheObjectHaveNoScaleToTell) {
  const auto folder = std::filesystem::temp_directory_path() / "kinora_displacement_scales";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "grow.osl") << "displacement grow(float by = .1) { P += by * N; }";
  std::ofstream(folder / "waves.osl")
      << "displacement waves(float by = .1) {\n  point o = transform(\"object\", P);\n"
         "  displace(\"object\", by * sin(3 * o[0]) * cos(3 * o[1]));\n}";
  const auto told = [&](const std::string& shader, const std::string& scale, const std::string& levels) {
    RenderRequest request = requestOf(levels + "Displace \"" + shader +
                                      "\" \"d\"\nObjectBegin \"o\"\nSphere .3 -.3 .3 360\nObjectEnd\nTranslate -.5 0 "
                                      "0\nObjectInstance \"o\"\nTranslate 1 0 0\nRotate 20 1 1 1\nScale " +
                                      scale + "\nObjectInstance \"o\"");
    request.rib = "Option \"searchpath\" \"string shader\" [\"" + folder.string() + "\"]\n" + request.rib;
    SceneRender r(request);
    EXPECT_TRUE(r.ok());
    return says(r, "DISPLACEMENT-SCALE");
  };
  for (const std::string levels : {"", "Attribute \"dice\" \"int levels\" [1] \"float micropolygonlength\" [.2]\n"}) {
    EXPECT_TRUE(told("grow", "2 2 2", levels)) << levels;
    EXPECT_TRUE(told("grow", ".5 .5 .5", levels)) << levels;
    EXPECT_FALSE(told("grow", "-1 1 1", levels)) << levels;
    EXPECT_FALSE(told("waves", "2 2 2", levels)) << levels;
    EXPECT_FALSE(told("waves", ".5 .5 .5", levels)) << levels;
  }
  std::filesystem::remove_all(folder);
}

// What is seen of a face decides what it is cut into, not how far it reaches.
TEST(DisplacedSurfaces, FacesThatReachFarAreCutWhereTheyAreSeen) {
  const std::string waves =
      "Pattern \"PxrFractal\" \"f\" \"int surfacePosition\" [0] \"float frequency\" [.7]\n"
      "Displace \"PxrDisplace\" \"d\" \"float dispAmount\" [.3] \"reference float "
      "dispScalar\" [\"f:resultF\"]\n";
  const auto of = [&](const std::string& projection, const std::string& turn, double side, const std::string& more) {
    RenderRequest r;
    r.rib = kWorld;
    r.rib.replace(r.rib.find("Projection"), r.rib.find("Shutter") - r.rib.find("Projection"), projection);
    const std::string s = std::to_string(side);
    r.rib += turn + more + waves + "PointsPolygons [4] [0 1 2 3] \"P\" [-" + s + " -" + s + " 0 " + s + " -" + s +
             " 0 " + s + " " + s + " 0 -" + s + " " + s + " 0]\nWorldEnd\n";
    r.channels = "Ci,a,z,Nn";
    return std::make_unique<SceneRender>(r);
  };
  const std::string flat = "Projection \"orthographic\"\nScreenWindow -2 2 -2 2\n";
  const auto small = of(flat, "Rotate 30 1 0 0\n", 8, ""), large = of(flat, "Rotate 30 1 0 0\n", 1e6, "");
  ASSERT_TRUE(small->ok() && large->ok());
  EXPECT_TRUE(large->messages().empty()) << large->messages()[0];
  EXPECT_LT(large->renderer().statistics().micropolygons, 200'000u);
  EXPECT_LT(between(*small, *large, "Nn").mean, 0.02);
  EXPECT_LT(between(*small, *large, "z").mean, 0.02);
  // as in perspective, down to the horizon
  const std::string eye = "Projection \"perspective\" \"fov\" [40]\n";
  const auto near = of(eye, "Translate 0 -.5 -5\nRotate 90 1 0 0\n", 60, ""),
             far = of(eye, "Translate 0 -.5 -5\nRotate 90 1 0 0\n", 1e5, "");
  ASSERT_TRUE(near->ok() && far->ok());
  EXPECT_TRUE(far->messages().empty()) << far->messages()[0];
  EXPECT_LT(far->renderer().statistics().micropolygons, 3'000'000u);
  image::Image n = near->channel("Nn"), m = far->channel("Nn");
  double sum = 0;
  const size_t rows = size_t(n.height()), row = n.pixels.size() / rows;
  for (size_t i = row * (rows - 12); i < n.pixels.size(); ++i)
    sum += std::abs(double(n.pixels[i]) - double(m.pixels[i])) / double(12 * row);
  EXPECT_LT(sum, 0.05);
  // more than can be made is told
  const auto fine = of(flat, "", 8, "Attribute \"dice\" \"float micropolygonlength\" [.001] \"int levels\" [0]\n");
  EXPECT_TRUE(fine->ok());
  EXPECT_TRUE(says(*fine, "DISPLACEMENT-COARSE"));
}

TEST(DisplacedSurfaces, FollowTheRateThatIsAsked) {
  const auto count = [](const std::string& rate) {
    SceneRender r(requestOf(rate + byDistance(0.1) + "Patch \"bilinear\" \"P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 0]"));
    return double(r.renderer().statistics().micropolygons);
  };
  const double usual = count("");
  // 2 units of 3.64 across 48 pixels: 26.4 by 26.4 micropolygons of a pixel each
  EXPECT_GT(usual, 26 * 26);
  EXPECT_LT(usual, 32 * 32);
  EXPECT_NEAR(count("Attribute \"dice\" \"float micropolygonlength\" [.5]\n") / usual, 4, 0.5);
  EXPECT_NEAR(count("ShadingRate 4\n") * 4 / usual, 1, 0.2);
}

}  // namespace
}  // namespace kinora::tests
