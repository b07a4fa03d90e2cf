// Proves: PxrBump gives the normals that its heights would give as geometry, and PxrNormalMap leans along its
// picture, through whole scenes: in every orientation of a manifold, on turned, mirrored, stretched and instanced
// cards, with coordinates of the surface, of a primitive variable and of a projection. Misses: images in atlases,
// curved surfaces.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <sstream>

#include "image/read_write.h"
#include "support/render_scene.h"

namespace kinora::tests {
namespace {

using Vec = std::array<double, 3>;
Vec operator+(Vec a, Vec b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec operator-(Vec a, Vec b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec operator*(Vec a, double f) { return {a[0] * f, a[1] * f, a[2] * f}; }
double dot(Vec a, Vec b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec cross(Vec a, Vec b) { return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]}; }
Vec unit(Vec a) { return a * (1 / std::sqrt(dot(a, a))); }
// on the side of the camera, which looks along z
Vec towardsCamera(Vec n) { return n[2] > 0 ? n * -1 : n; }

constexpr double kAlong = 0.9, kAcross = -0.5;  // heights rise along the rows and, downwards, across them

// One picture: heights where they are told apart, else one normal as a colour.
std::string pictureFile(const std::string& name, bool heights, Vec color = {0, 0, 0}) {
  constexpr int n = 64;
  image::Image p({0, 0, n, n},
                 {{"R", image::StoredType::Float}, {"G", image::StoredType::Float}, {"B", image::StoredType::Float}});
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x)
      for (int k = 0; k < 3; ++k)
        p.at(x, y)[k] = float(heights ? (kAlong * (x + 0.5) + kAcross * (y + 0.5)) / n + 1 : color[size_t(k)]);
  const std::string file = ::testing::TempDir() + name;
  EXPECT_TRUE(image::write(file, p).ok());
  return file;
}

// How a card lies: three of its corners, which hold its plane, and their texture coordinates.
struct Card {
  const char* name;
  Vec corner[3];  // and a fourth that completes the parallelogram
  double st[3][2];
  std::string before = "";  // requests that place it, and what they do: corner = scale * its own + shift
  Vec scale{1, 1, 1}, shift{0, 0, 0};
};
const Card kCards[] = {
    {"plain", {{-1, -1, 3}, {1, -1, 3}, {-1, 1, 3}}, {{.4, .4}, {.6, .4}, {.4, .6}}},
    {"from behind", {{1, -1, 3}, {-1, -1, 3}, {1, 1, 3}}, {{.6, .4}, {.4, .4}, {.6, .6}}},
    {"mirrored coordinates", {{-1, -1, 3}, {1, -1, 3}, {-1, 1, 3}}, {{.6, .4}, {.4, .4}, {.6, .6}}},
    {"turned", {{-1, -.6, 3}, {.6, -1, 3}, {-.6, 1, 3}}, {{.4, .4}, {.6, .4}, {.4, .6}}},
    {"tilted", {{-1, -1, 3}, {1, -1, 2.2}, {-1, 1, 3.9}}, {{.4, .4}, {.6, .4}, {.4, .6}}},
    {"sheared", {{-1, -1, 3}, {1, -1, 3}, {-.4, 1, 3}}, {{.4, .4}, {.65, .42}, {.43, .5}}},
    {"stretched",
     {{-2, -1, 3}, {2, -1, 3}, {-2, 1, 3}},
     {{.4, .4}, {.6, .4}, {.4, .6}},
     "Scale 2 0.5 1\n",
     {2, .5, 1}},
    {"mirrored",
     {{-1, -1, 3}, {1, -1, 3}, {-1, 1, 3.5}},
     {{.4, .4}, {.6, .4}, {.4, .6}},
     "Scale -1 1 1\n",
     {-1, 1, 1}},
};

// Order and meaning as in the manual of PxrManifold2D: turned, scaled, shifted, inverted.
struct Place {
  bool connected = true;
  double angle = 0, scaleS = 1, scaleT = 1;
  bool invertS = false, invertT = true;
  // Coordinates in the picture (t down) of texture coordinates; the shift keeps the card's middle in the picture's.
  void apply(double s, double t, double out[2]) const {
    const double a = angle * 3.14159265358979323846 / 180, c = std::cos(a), d = std::sin(a);
    const auto q = [&](double x, double y, double r[2]) {
      r[0] = (x * c - y * d) * scaleS;
      r[1] = (x * d + y * c) * scaleT;
    };
    double middle[2];
    q(s, t, out);
    q(0.5, 0.5, middle);
    for (int k = 0; k < 2; ++k) out[k] += connected ? 0.5 - middle[k] : 0;
    if (invertS) out[0] = 1 - out[0];
    if (invertT) out[1] = 1 - out[1];
  }
  std::string rib(const std::string& more) const {
    double at[2];
    Place plain = *this;
    plain.connected = plain.invertS = plain.invertT = false;
    plain.apply(0.5, 0.5, at);
    std::ostringstream out;
    out << "Pattern \"PxrManifold2D\" \"place\" \"float angle\" [" << angle << "] \"float scaleS\" [" << scaleS
        << "] \"float scaleT\" [" << scaleT << "] \"float offsetS\" [" << 0.5 - at[0] << "] \"float offsetT\" ["
        << 0.5 - at[1] << "] \"int invertS\" [" << invertS << "] \"int invertT\" [" << invertT << "] " << more
        << "\n";
    return out.str();
  }
};
std::vector<Place> places() {
  std::vector<Place> list{{false, 0, 1, 1, false, true}, {false, 0, 1, 1, false, false}};
  for (const double angle : {0., 90., 180., 270., 33.})
    for (const bool invertS : {false, true})
      for (const bool invertT : {false, true}) list.push_back({true, angle, 1, 1, invertS, invertT});
  list.push_back({true, 0, -1, 1});
  list.push_back({true, 0, 1, -1, false, false});
  list.push_back({true, 90, 1.5, -0.7});
  list.push_back({true, -20, 0.5, 1.2, true, false});
  return list;
}

struct Renders {
  std::string patterns;
  bool instanced = false;
  // The mean of resultN of the pattern "it" over the picture.
  Vec normal(const Card& c) const {
    std::ostringstream rib;
    rib << "Format 8 8 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [1]\n"
           "ScreenWindow -0.2 0.2 -0.2 0.2\nProjection \"orthographic\"\nWorldBegin\n"
        << patterns << "Bxdf \"PxrConstant\" \"c\" \"reference color emitColor\" [\"it:resultN\"]\n";
    std::ostringstream shape;
    Vec corners[4] = {c.corner[0], c.corner[1], c.corner[1] + c.corner[2] - c.corner[0], c.corner[2]};
    shape << c.before << "PointsPolygons [4] [0 1 2 3] \"vertex point P\" [";
    for (const Vec& p : corners)
      for (size_t k = 0; k < 3; ++k) shape << (p[k] - c.shift[k]) / c.scale[k] << " ";
    const double st[4][2] = {{c.st[0][0], c.st[0][1]},
                             {c.st[1][0], c.st[1][1]},
                             {c.st[1][0] + c.st[2][0] - c.st[0][0], c.st[1][1] + c.st[2][1] - c.st[0][1]},
                             {c.st[2][0], c.st[2][1]}};
    const auto floats = [&](const char* name, bool swapped) {
      shape << "] \"vertex float[2] " << name << "\" [";
      for (const auto& x : st) shape << x[swapped] << " " << x[!swapped] << " ";
    };
    floats("st", false);
    floats("other", true);
    shape << "]\n";
    if (instanced)
      rib << "ObjectBegin \"o\"\n" << shape.str() << "ObjectEnd\nObjectInstance \"o\"\n";
    else
      rib << shape.str();
    rib << "WorldEnd\n";
    RenderRequest r;
    r.rib = rib.str();
    SceneRender s(r);
    EXPECT_TRUE(s.ok());
    for (const std::string& m : s.messages())
      if (m.find("RENDER-NO-LIGHTS") == std::string::npos) ADD_FAILURE() << m;  // the card glows
    Vec n{0, 0, 0};
    if (!s.ok()) return n;
    const image::Image p = s.channel("Ci");
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) n = n + Vec{p.at(x, y)[0], p.at(x, y)[1], p.at(x, y)[2]} * (1 / 64.);
    return n;
  }
};

void expectNormal(Vec got, Vec expected, const std::string& what) {
  for (size_t k = 0; k < 3; ++k) EXPECT_NEAR(got[k], expected[k], 2e-3) << what << ", component " << k;
}
std::string text(const Card& c, const Place& p) {
  std::ostringstream out;
  out << c.name << (p.connected ? "" : " without manifold") << " angle " << p.angle << " scale " << p.scaleS << " "
      << p.scaleT << " invert " << p.invertS << " " << p.invertT;
  return out.str();
}
std::string invert(const Place& p) { return " \"int invertT\" [" + std::to_string(p.invertT) + "] "; }

// The plane of three corners that the heights move along their normal.
Vec displaced(const Card& c, const double heights[3]) {
  const Vec n = towardsCamera(unit(cross(c.corner[1] - c.corner[0], c.corner[2] - c.corner[0])));
  Vec p[3];
  for (size_t i = 0; i < 3; ++i) p[i] = c.corner[i] + n * heights[i];
  return towardsCamera(unit(cross(p[1] - p[0], p[2] - p[0])));
}

TEST(Slopes, BumpIsTheDisplacedCard) {
  const std::string file = pictureFile("kinora_heights.exr", true);
  constexpr double kScale = 3;
  for (const Card& c : kCards)
    for (const bool instanced : {false, true})
      for (const Place& p : places()) {
        if (instanced && p.angle != 90) continue;
        double heights[3];
        for (int i = 0; i < 3; ++i) {
          double q[2];
          p.apply(c.st[i][0], c.st[i][1], q);
          heights[i] = kScale * (kAlong * q[0] + kAcross * q[1]);
        }
        Renders r;
        r.instanced = instanced;
        r.patterns = p.rib("") + "Pattern \"PxrBump\" \"it\" \"string filename\" [\"" + file +
                     "\"] \"float scale\" [3] " +
                     (p.connected ? "\"reference struct manifold\" [\"place:result\"]\n" : invert(p) + "\n");
        expectNormal(r.normal(c), displaced(c, heights), text(c, p));
        // the same coordinates by name, whose s and t are exchanged
        if (!p.connected || instanced) continue;
        for (int i = 0; i < 3; ++i) {
          double q[2];
          p.apply(c.st[i][1], c.st[i][0], q);
          heights[i] = kScale * (kAlong * q[0] + kAcross * q[1]);
        }
        r.patterns = p.rib("\"string primvarS\" [\"other\"]") + "Pattern \"PxrBump\" \"it\" \"string filename\" [\"" +
                     file + "\"] \"float scale\" [3] \"reference struct manifold\" [\"place:result\"]\n";
        expectNormal(r.normal(c), displaced(c, heights), text(c, p) + " of a primitive variable");
      }
}

// A bump has no slopes of what feeds its height, but it has the file of a texture.
TEST(Slopes, ATextureAtInputBumpIsTheBumpsOwn) {
  const std::string file = "\"string filename\" [\"" + pictureFile("kinora_heights.exr", true) + "\"] ";
  const Card& c = kCards[3];
  const Place p{true, 90, 1.5, -0.7};
  const std::string manifold = "\"reference struct manifold\" [\"place:result\"]\n";
  Renders own, fed;
  own.patterns = p.rib("") + "Pattern \"PxrBump\" \"it\" \"float scale\" [3] " + file + manifold;
  for (const char* output : {"resultR", "resultG"}) {
    fed.patterns =
        p.rib("") + "Pattern \"PxrTexture\" \"image\" \"color colorScale\" [1.5 1.5 1.5] " + file + manifold +
        "Pattern \"PxrBump\" \"it\" \"float scale\" [2] \"reference float inputBump\" [\"image:" + output + "\"]\n";
    expectNormal(fed.normal(c), own.normal(c), output);
  }
  fed.patterns = "Pattern \"PxrTexture\" \"image\" \"int invertT\" [0] " + file +
                 "\nPattern \"PxrBump\" \"it\" \"reference float inputBump\" [\"image:resultB\"]\n";
  own.patterns = "Pattern \"PxrBump\" \"it\" \"int invertT\" [0] " + file + "\n";
  expectNormal(fed.normal(c), own.normal(c), "without manifold");
}

// Heights of patterns that are plug-ins: coordinates and places, which are linear, and an image that another pattern
// makes twice as bright.
TEST(Slopes, HeightsOfAnyPatternAreTheDisplacedCard) {
  constexpr double kScale = 1.5;
  const std::string file = pictureFile("kinora_heights.exr", true);
  const auto bump = [](const std::string& from) {
    return "Pattern \"PxrBump\" \"it\" \"float scale\" [1.5] \"reference float inputBump\" [\"" + from + "\"]\n";
  };
  const auto variable = [&](const std::string& name, const char* output) {
    return "Pattern \"PxrVariable\" \"x\" \"string variable\" [\"" + name + "\"]\n" +
           bump(std::string("x:") + output);
  };
  for (const Card& c : kCards)
    for (const bool instanced : {false, true}) {
      const std::string what = std::string(c.name) + (instanced ? " instanced, " : ", ");
      const auto expect = [&](const std::string& patterns, const auto& heightOf, const char* name) {
        Renders r;
        r.instanced = instanced;
        r.patterns = patterns;
        double heights[3];
        for (int i = 0; i < 3; ++i) heights[i] = kScale * heightOf(i);
        expectNormal(r.normal(c), displaced(c, heights), what + name);
      };
      expect(
          variable("s", "resultR"), [&](int i) { return c.st[i][0]; }, "s");
      expect(
          variable("t", "resultR"), [&](int i) { return c.st[i][1]; }, "t");
      expect(
          variable("PW", "resultR"), [&](int i) { return c.corner[i][0]; }, "x of the world");
      expect(
          variable("Po", "resultG"), [&](int i) { return (c.corner[i][1] - c.shift[1]) / c.scale[1]; }, "own y");
      // their mean is the height
      expect(
          "Pattern \"PxrPrimvar\" \"x\" \"string varname\" [\"other\"] \"string type\" [\"float2\"]\n" +
              bump("x:resultRGB"),
          [&](int i) { return (c.st[i][0] + c.st[i][1]) / 3; }, "the mean of two");
      const Place p{true, 33, 1.5, -0.7};
      expect(
          p.rib("") + "Pattern \"PxrTexture\" \"image\" \"string filename\" [\"" + file +
              "\"] \"reference struct manifold\" [\"place:result\"]\n"
              "Pattern \"PxrExposure\" \"twice\" \"float stops\" [1] \"reference color inputRGB\" "
              "[\"image:resultRGB\"]\n" +
              bump("twice:resultRGB"),
          [&](int i) {
            double q[2];
            p.apply(c.st[i][0], c.st[i][1], q);
            return 2 * (kAlong * q[0] + kAcross * q[1]);
          },
          "an image in a network");
    }
}

// A bump in what feeds a bump: the height is a component of a bent normal, which is the same everywhere here.
TEST(Slopes, OfBumpsThatFeedBumps) {
  const Card& c = kCards[3];
  Renders r;
  const std::string s =
      "Pattern \"PxrVariable\" \"s\" \"string variable\" [\"s\"]\n"
      "Pattern \"PxrBump\" \"first\" \"float scale\" [2] \"reference float inputBump\" "
      "[\"s:resultR\"]\n";
  r.patterns = s + "Pattern \"PxrBump\" \"it\" \"reference float inputBump\" [\"first:resultN\"]\n";
  const double none[3] = {0, 0, 0};
  expectNormal(r.normal(c), displaced(c, none), "a constant height");
  r.patterns = s +
               "Pattern \"PxrBump\" \"it\" \"reference float inputBump\" [\"s:resultR\"] "
               "\"reference normal inputN\" [\"first:resultN\"]\n";
  Renders once;
  once.patterns =
      s + "Pattern \"PxrBump\" \"it\" \"float scale\" [2] \"reference float inputBump\" [\"s:resultR\"]\n";
  const Vec bent = r.normal(c), first = once.normal(c), flat = displaced(c, none);
  EXPECT_LT(dot(bent, flat), dot(first, flat) - 0.01) << "bent further";
}

TEST(Slopes, NoiseBendsWhatANumberDoesNot) {
  const auto spreadOf = [](const std::string& input) {
    RenderRequest r;
    r.rib =
        "Format 32 32 1\nHider \"raytrace\" \"int maxsamples\" [1]\nProjection \"orthographic\"\nWorldBegin\n"
        "Pattern \"PxrFractal\" \"f\" \"float frequency\" [2]\nPattern \"PxrBump\" \"b\" " +
        input +
        "\nBxdf \"PxrConstant\" \"m\" \"reference color emitColor\" [\"b:resultN\"]\n"
        "PointsPolygons [4] [0 1 2 3] \"P\" [-1 -1 2 1 -1 2 1 1 2 -1 1 2]\nWorldEnd\n";
    SceneRender s(r);
    EXPECT_TRUE(s.ok());
    for (const std::string& m : s.messages())
      if (m.find("RENDER-NO-LIGHTS") == std::string::npos) ADD_FAILURE() << m;
    const image::Image p = s.channel("Ci");
    double squares = 0;
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) squares += (p.at(x, y)[0] * p.at(x, y)[0] + p.at(x, y)[1] * p.at(x, y)[1]) / 1024.;
    return std::sqrt(squares);
  };
  const std::string connected = "\"reference float inputBump\" [\"f:resultF\"] ";
  EXPECT_GT(spreadOf(connected + "\"float scale\" [0.9]"), 0.05);
  EXPECT_GT(spreadOf(connected + "\"float scale\" [0.9]"), 1.5 * spreadOf(connected + "\"float scale\" [0.3]"));
  EXPECT_LT(spreadOf(connected + "\"int disable\" [1]"), 1e-5);
  EXPECT_LT(spreadOf("\"float inputBump\" [0.7]"), 1e-5);
}

// Projections along axes: the card faces z, so that the picture lies in x and y.
TEST(Slopes, BumpOfAProjectionIsTheDisplacedCard) {
  const std::string file = pictureFile("kinora_heights.exr", true);
  for (const Card& c : {kCards[0], kCards[3], kCards[6], kCards[7]})
    for (const char* kind : {"PxrRoundCube", "PxrManifold3D"}) {
      const bool cube = kind == std::string("PxrRoundCube");
      double heights[3];
      for (int i = 0; i < 3; ++i) {
        // in the card's own space; a cube's picture is seen from the outside, here the side of the camera
        const double x = c.corner[i][0] / c.scale[0], y = c.corner[i][1] / c.scale[1];
        heights[i] = kAlong * (cube ? -x : x) + kAcross * (cube ? 1 - y : y);
      }
      // the picture repeats every unit: its seam is moved out of sight
      Card shifted = c;
      shifted.shift = {0.5 * c.scale[0], 0.5 * c.scale[1], 0};
      shifted.before = "Translate " + std::to_string(shifted.shift[0]) + " " + std::to_string(shifted.shift[1]) +
                       " 0\n" + c.before;
      Renders r;
      r.patterns =
          "Pattern \"" + std::string(kind) + "\" \"place\" " + (cube ? "\"float transitionWidth\" [0]" : "") +
          "\nPattern \"PxrBump\" \"it\" \"string filename\" [\"" + file +
          "\"] \"float scale\" [1] \"reference struct manifold\" [\"place:result" + (cube ? "Multi" : "") + "\"]\n";
      expectNormal(r.normal(shifted), displaced(c, heights), std::string(c.name) + " " + kind);
    }
}

// Cards without shear and stretching: the frame is the picture's rows and columns.
TEST(Slopes, NormalMapLeansAlongItsPicture) {
  const std::string file = pictureFile("kinora_normals.exr", false, {0.7, 0.65, 0.9});
  for (const Card& c : {kCards[0], kCards[1], kCards[2], kCards[4], kCards[7]})
    for (const Place& p : places())
      for (int orientation = 0; orientation < 4; ++orientation) {
        if (p.angle != 0 && std::abs(p.scaleS) != std::abs(p.scaleT)) continue;
        // where s and t of the picture are 1: corners of the plane, by inverting the coordinates of three corners
        double q[3][2];
        for (int i = 0; i < 3; ++i) p.apply(c.st[i][0], c.st[i][1], q[i]);
        const double a = q[1][0] - q[0][0], b = q[1][1] - q[0][1], d = q[2][0] - q[0][0], e = q[2][1] - q[0][1];
        const Vec e1 = c.corner[1] - c.corner[0], e2 = c.corner[2] - c.corner[0];
        const double det = a * e - b * d;
        const Vec right = unit((e1 * e - e2 * b) * (1 / det)), downAny = (e2 * a - e1 * d) * (1 / det);
        const Vec n = towardsCamera(unit(cross(e1, e2)));
        const Vec down = unit(downAny - right * dot(right, downAny));
        const double red = orientation & 1 ? -0.4 : 0.4, green = orientation & 2 ? -0.3 : 0.3;
        const Vec expected = unit(right * red - down * green + n * 0.8);
        Renders r;
        const std::string rest =
            "\"int orientation\" [" + std::to_string(orientation) + "] " +
            (p.connected ? "\"reference struct manifold\" [\"place:result\"]\n" : invert(p) + "\n");
        r.patterns = p.rib("") + "Pattern \"PxrNormalMap\" \"it\" \"string filename\" [\"" + file + "\"] " + rest;
        expectNormal(r.normal(c), expected, text(c, p) + " orientation " + std::to_string(orientation));
        if (p.angle != 90) continue;
        r.patterns = p.rib("") + "Pattern \"PxrNormalMap\" \"it\" \"color inputRGB\" [0.7 0.65 0.9] " + rest;
        expectNormal(r.normal(c), expected, text(c, p) + " by inputRGB");
      }
}

}  // namespace
}  // namespace kinora::tests
