// Proves: built-in channel sources hold what they say, against closed forms on a ball, a square and a moving card;
// primvars and ids come through; what no object has is a message and black. Misses: curves, points, volumes.
#include <gtest/gtest.h>

#include <cmath>

#include "plugin/registry.h"
#include "support/render_scene.h"

namespace kinora::tests {
namespace {

constexpr int kSide = 32;

// An orthographic view of the square -1..1, with what `world` says in it.
RenderRequest request(const std::string& channels, const std::string& world, const std::string& options = "") {
  RenderRequest r;
  r.rib =
      "Hider \"raytrace\" \"int maxsamples\" [16]\nFormat 32 32 1\nPixelFilter \"box\" 1 1\n"
      "Projection \"orthographic\"\n" +
      options + "WorldBegin\nLight \"PxrDomeLight\" \"sky\"\n" + world + "\nWorldEnd\n";
  r.channels = channels;
  return r;
}
const char* const kBall = "Translate 0.1 0 5\nSphere 0.8 -0.8 0.8 360\n";
// A square of 2 by 2 at depth 3, facing the camera, u to the right, v up.
const char* const kSquare =
    "Translate 0 0 3\nPatch \"bilinear\" \"vertex point P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]\n";

float at(SceneRender& r, const std::string& channel, int x, int y, int k = 0) {
  const image::Image i = r.channel(channel);
  return i.pixels.empty() ? NAN : i.at(x, y)[k];
}
// Of the centre of pixel (x, y), in the plane of the screen.
float screen(int x) { return (float(x) + 0.5f) / (kSide / 2.f) - 1.f; }

TEST(Sources, OfABall) {
  SceneRender r(request(
      "Ci,a,Oi,z,zback,zfiltered,depth,P,N,Nn,Ngn,Vn,VLen,curvature,outsideIOR,sampleCount,cpuTime,PRadius,mpSize,id",
      std::string("Attribute \"identifier\" \"int id\" [7]\n") + kBall));
  ASSERT_TRUE(r.ok());
  EXPECT_TRUE(r.messages().empty()) << r.messages()[0];
  const int x = 13, y = 18;
  // the ball's centre is at (0.1, 0, 5); rows go down
  const float px = screen(x) - 0.1f, py = -screen(y), pz = -std::sqrt(0.64f - px * px - py * py);
  EXPECT_NEAR(at(r, "z", x, y), 5 + pz, 0.03f) << "of the nearest sample";
  EXPECT_NEAR(at(r, "zfiltered", x, y), 5 + pz, 0.01f);
  EXPECT_EQ(at(r, "depth", x, y), at(r, "zfiltered", x, y));
  EXPECT_GE(at(r, "zback", x, y), at(r, "z", x, y));
  EXPECT_NEAR(at(r, "VLen", x, y), 5 + pz, 0.01f);
  EXPECT_NEAR(at(r, "P", x, y, 0), px + 0.1f, 0.01f);
  EXPECT_NEAR(at(r, "P", x, y, 1), py, 0.01f);
  EXPECT_NEAR(at(r, "P", x, y, 2), 5 + pz, 0.01f);
  for (const char* n : {"N", "Nn", "Ngn"}) {
    EXPECT_NEAR(at(r, n, x, y, 0), px / 0.8f, 0.03f) << n;
    EXPECT_NEAR(at(r, n, x, y, 2), pz / 0.8f, 0.03f) << n;
  }
  EXPECT_NEAR(at(r, "Vn", x, y, 2), -1, 1e-5f);
  EXPECT_NEAR(at(r, "curvature", x, y), 1 / 0.8f, 0.02f);
  EXPECT_EQ(at(r, "outsideIOR", x, y), 1);
  EXPECT_EQ(at(r, "sampleCount", x, y), 16);
  EXPECT_EQ(at(r, "sampleCount", 0, 0), 16) << "misses are samples";
  EXPECT_GT(at(r, "cpuTime", x, y), 0);
  EXPECT_LT(at(r, "cpuTime", x, y), 16);
  EXPECT_GT(at(r, "PRadius", x, y), 0);
  EXPECT_NEAR(at(r, "mpSize", x, y), 2 * at(r, "PRadius", x, y), 1e-5f);
  EXPECT_EQ(at(r, "id", x, y), 7);
  EXPECT_EQ(at(r, "id", 0, 0), 0);
  EXPECT_EQ(at(r, "a", x, y), 1);
  EXPECT_EQ(at(r, "Oi", x, y, 1), 1);
  EXPECT_EQ(at(r, "a", 0, 0), 0);
}

TEST(Sources, AlphaIsThatOfSurfacesForEveryIntegrator) {
  Registry registry;
  for (const Descriptor* d : registry.all(Kind::Integrator)) {
    SceneRender r(request("Ci,a", kBall, std::string("Integrator \"") + d->name + "\" \"i\"\n"));
    ASSERT_TRUE(r.ok());
    EXPECT_EQ(at(r, "a", 13, 18), 1) << d->name;
    EXPECT_EQ(at(r, "a", 0, 0), 0) << d->name;
  }
}

TEST(Sources, OfASquare) {
  SceneRender r(request(
      "Ci,u,v,w,s,t,st,__st,du,dvfp,dw,dPdu,dPdv,dPdw,Tn,Po,dPdtime,dPcameradtime,motionFore,motionBack,biasR,biasT,"
      "incidentRaySpread,incidentRayRadius,PRadius,time,id2",
      std::string("Attribute \"identifier\" \"int id2\" [9]\n") + kSquare));
  ASSERT_TRUE(r.ok());
  EXPECT_TRUE(r.messages().empty()) << r.messages()[0];
  const int x = 5, y = 20;
  const float u = (screen(x) + 1) / 2, v = (-screen(y) + 1) / 2;
  EXPECT_NEAR(at(r, "u", x, y), u, 1e-3f);
  EXPECT_NEAR(at(r, "v", x, y), v, 1e-3f);
  EXPECT_EQ(at(r, "w", x, y), 0);
  EXPECT_NEAR(at(r, "s", x, y), at(r, "st", x, y, 0), 1e-6f);
  EXPECT_NEAR(at(r, "t", x, y), at(r, "__st", x, y, 1), 1e-6f);
  EXPECT_NEAR(at(r, "dPdu", x, y, 0), 2, 1e-3f);
  EXPECT_NEAR(at(r, "dPdv", x, y, 1), 2, 1e-3f);
  EXPECT_EQ(at(r, "dPdw", x, y, 1), 0);
  EXPECT_NEAR(at(r, "Tn", x, y, 0), 1, 1e-4f);
  const float radius = at(r, "PRadius", x, y);
  EXPECT_NEAR(at(r, "du", x, y), radius, 1e-4f) << "the footprint's diameter over |dPdu| = 2";
  EXPECT_NEAR(at(r, "dvfp", x, y), radius, 1e-4f);
  EXPECT_EQ(at(r, "dw", x, y), 0);
  EXPECT_EQ(at(r, "incidentRayRadius", x, y), radius);
  EXPECT_EQ(at(r, "incidentRaySpread", x, y), 0) << "parallel rays";
  EXPECT_NEAR(at(r, "Po", x, y, 2), 0, 1e-3f) << "object space";
  for (const char* still : {"dPdtime", "dPcameradtime", "motionFore", "motionBack"})
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(at(r, still, x, y, k), 0, 1e-4f) << still;
  EXPECT_GT(at(r, "biasR", x, y), 0);
  EXPECT_EQ(at(r, "biasR", x, y), at(r, "biasT", x, y));
  EXPECT_GT(at(r, "time", x, y), 0.3f);
  EXPECT_LT(at(r, "time", x, y), 0.7f);
  EXPECT_EQ(at(r, "id2", x, y), 9);
}

// Identifiers that a float does not hold are told; those that it does hold are not.
TEST(Sources, IdentifiersWithTooManyBits) {
  for (const auto& [id, isTold] : {std::pair{"16777216", false}, {"16777217", true}, {"-5", true}, {"0", false}}) {
    SceneRender r(request("Ci,id", std::string("Attribute \"identifier\" \"int id\" [") + id + "]\n" + kBall));
    ASSERT_TRUE(r.ok());
    bool told = false;
    for (const std::string& m : r.messages())
      told |= m.find("DISPLAY-ID") != std::string::npos && m.find(id) != std::string::npos;
    EXPECT_EQ(told, isTold) << id;
  }
  SceneRender other(request("Ci,a", std::string("Attribute \"identifier\" \"int id\" [16777217]\n") + kBall));
  EXPECT_TRUE(other.messages().empty()) << "nothing shows it";
}

// The Hider's samplemotion 0: everything stands where it is when the shutter opens, object and camera, and its motion
// is that of the blurred picture.
TEST(Sources, MotionWithoutBlur) {
  const std::string card =
      "MotionBegin [0 1]\nTranslate 0 0 3\nTranslate 0.5 0 3\nMotionEnd\n"
      "Polygon \"vertex point P\" [-0.5 -2 0  0.25 -2 0  0.25 2 0  -0.5 2 0]\n";
  const std::string still = "Hider \"raytrace\" \"int maxsamples\" [16] \"int samplemotion\" [0]\n";
  for (const char* camera : {"", "Projection \"PxrCamera\" \"fov\" [90] \"float duration\" [0.25]\n"}) {
    SCOPED_TRACE(camera);
    // at distance 3 a field of 90 degrees shows 6 units
    const float pixels = *camera ? 32 / 6.f : 16.f;
    SceneRender r(request("Ci,a,dPdtime,motionFore,motionBack,time", card, "Shutter 0 1\n" + still + camera));
    ASSERT_TRUE(r.ok());
    for (int x = 0; x < kSide; ++x) {
      const float left = 16 - 0.5f * pixels, right = 16 + 0.25f * pixels;
      const float expected =
          std::max(0.f, std::min(float(x + 1), right) - std::max(float(x), left));  // at most 1: of its width
      EXPECT_NEAR(at(r, "a", x, 16), expected, 0.07f) << x;
    }
    EXPECT_EQ(at(r, "time", 15, 16), 0);
    EXPECT_NEAR(at(r, "dPdtime", 15, 16, 0), 0.5, 2e-3);
    EXPECT_NEAR(at(r, "motionFore", 15, 16, 0), 0.5f * pixels, 0.05);
    EXPECT_NEAR(at(r, "motionBack", 15, 16, 0), -0.5f * pixels, 0.05);
  }
  // a camera in motion: the same picture the other way about
  SceneRender r(
      request("Ci,a,dPcameradtime", "Translate 0 0 3\nPolygon \"P\" [-0.5 -2 0  0.25 -2 0  0.25 2 0  -0.5 2 0]",
              "Shutter 0 1\n" + still + "MotionBegin [0 1]\nTranslate 0 0 0\nTranslate 0.5 0 0\nMotionEnd\n"));
  ASSERT_TRUE(r.ok());
  for (int x = 0; x < kSide; ++x) EXPECT_EQ(at(r, "a", x, 16), x >= 8 && x < 20 ? 1 : 0) << x;
  EXPECT_NEAR(at(r, "dPcameradtime", 15, 16, 0), 0.5, 2e-3);
}

// Rigid and deforming motion say the same.
TEST(Sources, MotionInTheWorldAndInThePicture) {
  const std::string rigid =
      "MotionBegin [0 1]\nTranslate 0 0 3\nTranslate 0.25 0.125 3\nMotionEnd\n"
      "Polygon \"vertex point P\" [-2 -2 0  2 -2 0  2 2 0  -2 2 0]\n";
  const std::string deforming =
      "Translate 0 0 3\nMotionBegin [0 1]\nPolygon \"vertex point P\" [-2 -2 0  2 -2 0  2 2 0  -2 2 0]\n"
      "Polygon \"vertex point P\" [-1.75 -1.875 0  2.25 -1.875 0  2.25 2.125 0  -1.75 2.125 0]\nMotionEnd\n";
  for (const std::string& world : {rigid, deforming}) {
    SceneRender r(request("Ci,dPdtime,dPcameradtime,motionFore,motionBack", world, "Shutter 0 1\n"));
    ASSERT_TRUE(r.ok());
    for (const int x : {3, 16, 29}) {
      EXPECT_NEAR(at(r, "dPdtime", x, 9, 0), 0.25, 2e-3) << world;
      EXPECT_NEAR(at(r, "dPdtime", x, 9, 1), 0.125, 2e-3);
      EXPECT_NEAR(at(r, "dPcameradtime", x, 9, 0), 0.25, 2e-3);
      // 16 pixels a unit; rows go down
      EXPECT_NEAR(at(r, "motionFore", x, 9, 0), 4, 0.05);
      EXPECT_NEAR(at(r, "motionFore", x, 9, 1), -2, 0.05);
      EXPECT_NEAR(at(r, "motionBack", x, 9, 0), -4, 0.05);
    }
  }
  // strands, which have control points in place of triangles
  const std::string curves = [] {
    std::string text = "Translate 0 0 3\nMotionBegin [0 1]\n";
    for (const double move : {0.0, 0.25}) {
      text += "Curves \"cubic\" [13] \"nonperiodic\" \"P\" [";
      for (int k = 0; k < 13; ++k)
        text += std::to_string(-1.8 + 0.3 * k + move) + " " + std::to_string(0.4375 + move / 2) + " 0 ";
      text += "] \"constantwidth\" [0.5]\n";
    }
    return text + "MotionEnd\n";
  }();
  for (const std::string& world : {curves, "MotionBegin [0 1]\nTranslate 0 0 0\nTranslate 0.25 0.125 0\nMotionEnd\n" +
                                               std::string("Translate 0 0 3\nPoints \"P\" [0 0.4375 0] "
                                                           "\"constantwidth\" [2]\n")}) {
    SceneRender r(request("Ci,dPdtime", world, "Shutter 0 1\n"));
    ASSERT_TRUE(r.ok());
    for (const int x : {13, 16, 19}) {
      EXPECT_NEAR(at(r, "dPdtime", x, 8, 0), 0.25, 2e-3) << world;
      EXPECT_NEAR(at(r, "dPdtime", x, 8, 1), 0.125, 2e-3) << world;
    }
  }
  // a camera that moves instead: P stands still, its place in the picture does not
  SceneRender r(request("Ci,dPdtime,dPcameradtime,motionFore", kSquare,
                        "Shutter 0 1\nMotionBegin [0 1]\nTranslate 0 0 0\nTranslate 0.25 0 0\nMotionEnd\n"));
  ASSERT_TRUE(r.ok());
  EXPECT_NEAR(at(r, "dPdtime", 16, 16, 0), 0, 1e-3);
  EXPECT_NEAR(at(r, "dPcameradtime", 16, 16, 0), 0.25, 2e-3);
  EXPECT_NEAR(at(r, "motionFore", 16, 16, 0), 4, 0.05);
}

// Exporters write reference positions as "__Pref" or as "Pref"; the channel is "__Pref".
TEST(Sources, ReferencesByEitherName) {
  for (const std::string& name : {std::string("__"), std::string()}) {
    SceneRender r(request("__Pref,__Nref,Pref",
                          "Translate 0 0 3\nPatch \"bilinear\" \"vertex point P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0]"
                          " \"vertex point " +
                              name + "Pref\" [5 0 -3  7 0 -3  5 2 -3  7 2 -3] \"constant normal " + name +
                              "Nref\" [0 1 0]\n",
                          "DisplayChannel \"point __Pref\"\nDisplayChannel \"normal __Nref\"\n"
                          "DisplayChannel \"point Pref\"\n"));
    ASSERT_TRUE(r.ok());
    EXPECT_NEAR(at(r, "__Pref", 8, 8, 0), 6 + screen(8), 0.04) << name;
    EXPECT_NEAR(at(r, "__Pref", 8, 8, 1), 1 - screen(8), 0.04) << name;
    EXPECT_NEAR(at(r, "__Nref", 8, 8, 1), 1, 1e-4) << name;
    // the primvar itself has one name
    EXPECT_EQ(at(r, "Pref", 8, 8, 0) > 1, name.empty());
    EXPECT_EQ(r.messages().size(), name.empty() ? 0u : 1u);
  }
}

TEST(Sources, PrimvarsAndWhatIsMissing) {
  const std::string world =
      "Translate 0 0 3\nPolygon \"vertex point P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0] \"vertex color warmth\" [1 0 0  "
      "1 0 0  0 0 1  0 0 1]"
      " \"uniform float weight\" [0.25]\n";
  SceneRender r(
      request("Ci,warmth,heavy,nothing", world,
              "DisplayChannel \"color warmth\"\nDisplayChannel \"float heavy\" \"string source\" [\"float weight\"]\n"
              "DisplayChannel \"color nothing\"\n"));
  ASSERT_TRUE(r.ok());
  const float v = (-screen(10) + 1) / 2;
  EXPECT_NEAR(at(r, "warmth", 7, 10, 0), 1 - v, 2e-3f);
  EXPECT_NEAR(at(r, "warmth", 7, 10, 2), v, 2e-3f);
  EXPECT_EQ(at(r, "heavy", 7, 10), 0.25f);
  EXPECT_EQ(at(r, "nothing", 7, 10), 0);
  std::string all;
  for (const std::string& m : r.messages()) all += m + "\n";
  EXPECT_NE(
      all.find("DISPLAY-SOURCE: no primvar, PxrTee, PxrMatteID, light or filter of the scene gives \"nothing\""),
      std::string::npos)
      << all;
  SceneRender misspelt(request(
      "Ci,zz,Nn", world, "DisplayChannel \"float zz\" \"string source\" [\"PRADIUS\"]\nDisplayChannel \"int Nn\"\n"));
  ASSERT_TRUE(misspelt.ok());
  all.clear();
  for (const std::string& m : misspelt.messages()) all += m + "\n";
  EXPECT_NE(all.find("did you mean \"PRadius\""), std::string::npos) << all;
  EXPECT_NE(all.find("DISPLAY-CHANNEL-TYPE: channel \"Nn\" is declared as int"), std::string::npos) << all;
  EXPECT_NEAR(at(misspelt, "Nn", 7, 10, 2), -1, 1e-4f) << "as what the source is";
}

}  // namespace
}  // namespace kinora::tests
