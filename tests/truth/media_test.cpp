// Media that fill space, against closed forms and quadrature: transmittance of even and uneven media by channel, to
// the camera and to shadows; emission; light scattered once from a point light; what a half space reflects
// (Chandrasekhar's H function); furnaces of media that lose nothing, whatever their density, shape and overlap; and
// the roads to one answer: fields by name, by network, as solids of other requests. Misses: grids of files
// (media_files_test), moving media, other integrators.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

constexpr double kPi = std::numbers::pi;

std::string numbers(std::initializer_list<double> list) {
  std::string out = "[";
  for (const double x : list) out += std::to_string(x) + " ";
  return out + "]";
}
std::string medium(const std::string& parameters) { return "Bxdf \"PxrVolume\" \"m\" " + parameters + "\n"; }
// From x = y = -3 to 3, and z as said.
std::string box(double from, double to, const std::string& more = "[0 0 0]") {
  return "Volume \"box\" " + numbers({-3, 3, -3, 3, from, to}) + " " + more + "\n";
}
const char* const kSky = "Light \"PxrDomeLight\" \"sky\" \"float intensity\" [1]\n";

image::Image picture(const std::string& rib, const std::string& channel = "Ci") {
  return pictureTold(rib, {"RENDER-NO-LIGHTS"}, channel);
}
std::string absorbing(const std::string& color, const std::string& more = "") {
  return medium("\"color diffuseColor\" [0 0 0] \"color densityColor\" " + color + " " + more);
}

// A white floor that looks at the sun and the camera alike, through what only light sees.
std::string floorInTheSun(const std::string& between, int samples) {
  return orthographic(32, 0.5, samples) + unbiased(0) +
         "WorldBegin\nAttributeBegin\nLight \"PxrDistantLight\" \"sun\" \"float intensity\" [1] "
         "\"float angleExtent\" [0]\nAttributeEnd\nAttributeBegin Attribute \"visibility\" \"int camera\" [0]\n" +
         between +
         "AttributeEnd\nBxdf \"PxrDiffuse\" \"floor\" \"color diffuseColor\" [1 1 1]\n"
         "Polygon \"P\" [-9 -9 5  9 -9 5  9 9 5  -9 9 5]\nWorldEnd\n";
}

TEST(Media, LetThroughWhatBeerAndLambertSay) {
  // to the camera, by chance; and alpha is the rest
  const std::string scene = orthographic(32, 0.5, 64) + unbiased(2) + "WorldBegin\n" + kSky +
                            absorbing("[0.2 0.7 2]") + box(2, 3.5) + "WorldEnd\n";
  const image::Image seen = picture(scene);
  const double sigma[3] = {0.2, 0.7, 2};
  double all = 0;
  for (int c = 0; c < 3; ++c) {
    EXPECT_MEAN(overPixels(seen, c), std::exp(-1.5 * sigma[c]), 0.006);
    all += std::exp(-1.5 * sigma[c]) / 3;
  }
  const auto alpha = overPixels(picture(orthographic(32, 0.5, 64) + unbiased(2) + "WorldBegin\n" +
                                            absorbing("[0.2 0.7 2]") + box(2, 3.5) + "WorldEnd\n",
                                        "a"));
  EXPECT_MEAN(alpha, 1 - all, 0.006);
}

// To the camera, and to what is seen through them. Lights are not clipped.
TEST(Media, AreClippedAsSurfacesAre) {
  struct Case {
    const char* clipping;
    double inside;  // of the box's length, in which extinction is 1
  };
  const Case cases[] = {{"Clipping .1 100", 1},
                        {"Clipping .1 1.5", 0},
                        {"Clipping .1 2.25", .25},
                        {"Clipping 2.5 2.75", .25},
                        {"ClippingPlane 0 0 2.5  0 0 1", .5}};
  for (const Case& c : cases)
    for (const bool isEven : {true, false}) {
      SCOPED_TRACE(std::string(c.clipping) + (isEven ? ", even" : ", of voxels"));
      const std::string voxels = "[2 2 2] \"varying float density\" [1 1 1 1 1 1 1 1]";
      const std::string own =
          isEven ? absorbing("[1 1 1]") + box(2, 3)
                 : absorbing("[1 1 1]", "\"string densityFloatPrimVar\" [\"density\"]") + box(2, 3, voxels);
      const std::string head = orthographic(32, 0.5, 32) + unbiased(2) + c.clipping + "\nWorldBegin\n";
      EXPECT_MEAN(overPixels(picture(head + own + "WorldEnd\n", "a")), 1 - std::exp(-c.inside), 0.01);
      EXPECT_MEAN(overPixels(picture(head + kSky + own + "WorldEnd\n")), std::exp(-c.inside), 0.01);
    }
}

TEST(Media, ShadowsOfEvenMediaAreExact) {
  const image::Image seen = picture(floorInTheSun(absorbing("[0.2 0.7 2]") + box(2, 3.5), 16)),
                     bare = picture(floorInTheSun("", 16));
  const double sigma[3] = {0.2, 0.7, 2};
  for (int c = 0; c < 3; ++c) {
    ASSERT_GT(overPixels(bare, c).mean(), 0.1);
    EXPECT_NEAR(overPixels(seen, c).mean() / overPixels(bare, c).mean(), std::exp(-1.5 * sigma[c]), 2e-5);
  }
}

// A ramp of density from 0 to 2 along the way, of mean 1: by field, by field through a network, and as factor of a
// colour. All the same as an even medium.
// Boundaries that are boxes are crossed by themselves where they are few, and even media without tracks where all are.
// Small ones behind everything make the difference: the paths are the same, but for what rounding decides.
TEST(Media, AreTheSameHoweverTheirBoundariesAreCrossed) {
  const std::string voxels = "[3 1 2] \"varying float density\" [.2 1 .4  .9 .1 .6]", far = "Translate 0 0 -300\n",
                    tiny = "Volume \"box\" [-.01 .01 -.01 .01 -.01 .01] [0 0 0]\n",
                    uneven = medium(
                        "\"string densityFloatPrimVar\" [\"density\"] \"color densityColor\" [.5 1 2] "
                        "\"int multiScatter\" [1]");
  std::string boxes = "AttributeBegin\n" + far + medium("");
  for (int k = 0; k < 8; ++k) boxes += "Translate .1 0 0\n" + tiny;
  boxes += "AttributeEnd\n";
  const std::string notEven = "AttributeBegin\n" + far + uneven + "Volume \"box\" [-.01 .01 -.01 .01 -.01 .01] " +
                              voxels + "\nAttributeEnd\n";
  const auto scene = [&](const std::string& own, const std::string& more, double eye) {
    return "Format 24 24 1\nPixelFilter \"box\" 1 1\nProjection \"perspective\" \"fov\" [70]\n"
           "Hider \"raytrace\" \"int maxsamples\" [16]\n" +
           unbiased(3) + "Translate 0 0 " + std::to_string(eye) + "\nWorldBegin\n" + kSky +
           "Bxdf \"PxrDiffuse\" \"floor\"\nPolygon \"P\" [-9 -1.2 -9  -9 -1.2 9  9 -1.2 9  9 -1.2 -9]\n"
           "AttributeBegin\nRotate 30 1 1 0\nSkew 20 0 1 0 1 0 0\nScale 1 -1.3 .7\n" +
           own + "AttributeEnd\nAttributeBegin\nTranslate .5 0 .4\n" + medium("\"float densityFloat\" [.3]") +
           "Volume \"box\" [-1 1 -1 1 -1 1] [0 0 0]\nAttributeEnd\n" + more + "WorldEnd\n";
  };
  const std::string even = medium("\"color densityColor\" [.3 .6 1.2]") + "Volume \"box\" [-1 2 -1 1 -1 1] [0 0 0]\n";
  for (const std::string& own : {even, uneven + "Volume \"box\" [-1 2 -1 1 -1 1] " + voxels + "\n"})
    for (const double eye : {5., .5}) {
      const image::Image plain = picture(scene(own, "", eye));
      for (const std::string& more : {boxes, notEven, boxes + notEven}) {
        const image::Image other = picture(scene(own, more, eye));
        double sums[2] = {0, 0};
        int differ = 0, all = 0;
        for (int y = 0; y < 24; ++y)
          for (int x = 0; x < 24; ++x)
            for (int c = 0; c < 3; ++c, ++all) {
              const double a = double(plain.at(x, y)[c]), b = double(other.at(x, y)[c]);
              sums[0] += a;
              sums[1] += b;
              differ += std::fabs(a - b) > 1e-3 * (1e-3 + a);
            }
        EXPECT_GT(sums[0] / all, 0.05);
        EXPECT_LT(differ, all / 50) << own << more;
        EXPECT_NEAR(sums[1] / sums[0], 1, 0.002);
      }
    }
}

TEST(Media, UnevenMediaTakeWhatTheirMeanTakes) {
  const std::string ramp =
      "[2 2 9] \"varying float density\" " +
      numbers({0, 0, 0,    0,    .25,  .25,  .25, .25, .5,  .5,  .5,   .5,   .75,  .75,  .75, .75, 1, 1,
               1, 1, 1.25, 1.25, 1.25, 1.25, 1.5, 1.5, 1.5, 1.5, 1.75, 1.75, 1.75, 1.75, 2,   2,   2, 2});
  const std::string network =
      "Pattern \"PxrPrimvar\" \"p\" \"string varname\" [\"density\"] \"string type\" [\"float\"]\n";
  const double expected = std::exp(-1.5), bare = overPixels(picture(floorInTheSun("", 16))).mean();
  for (const std::string& material :
       {absorbing("[1 1 1]", "\"string densityFloatPrimVar\" [\"density\"]"),
        network + absorbing("[1 1 1]", "\"reference float densityFloat\" [\"p:resultF\"]"),
        absorbing("[1 1 1]", "\"string densityColorPrimVar\" [\"density\"]")}) {
    const image::Image direct = picture(orthographic(32, 0.5, 64) + unbiased(2) + "WorldBegin\n" + kSky + material +
                                        box(2, 3.5, ramp) + "WorldEnd\n");
    SCOPED_TRACE(material);
    EXPECT_MEAN(overPixels(direct), expected, 0.006);
    const image::Image shadow = picture(floorInTheSun(material + box(2, 3.5, ramp), 64));
    SCOPED_TRACE(material);
    EXPECT_MEAN(overPixels(shadow), expected * bare, 0.006 * bare);
  }
}

TEST(Media, GlowAsTheirDepthAllows) {
  for (const double sigma : {0.0, 0.5, 3.0}) {
    const double d = 1.5, thick = sigma > 0 ? (1 - std::exp(-sigma * d)) / sigma : d;
    const image::Image seen = picture(
        orthographic(32, 0.5, 64) + unbiased(2) + "WorldBegin\n" +
        absorbing("[1 1 1]", "\"float densityFloat\" [" + std::to_string(sigma) + "] \"color emitColor\" [0.5 1 2]") +
        box(2, 3.5) + "WorldEnd\n");
    const double emitted[3] = {0.5, 1, 2};
    for (int c = 0; c < 3; ++c) EXPECT_MEAN(overPixels(seen, c), emitted[c] * thick, 0.01 * emitted[c] * thick);
  }
}

double henyeyGreenstein(double g, double cosine) {
  return (1 - g * g) / (4 * kPi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

// Along z from 2 to 6, a point light at (h, 0, 4): the integral of what it sends to the eye.
TEST(Media, ScatterAPointLightOnceAsQuadratureSays) {
  constexpr double h = 0.8, albedo = 0.7;
  for (const double sigma : {0.3, 1.5})
    for (const double g : {0.0, 0.6, -0.4}) {
      double expected = 0;
      constexpr int kSteps = 20000;
      for (int k = 0; k < kSteps; ++k) {
        const double z = 2 + 4 * (k + 0.5) / kSteps, dz = 4 - z, r2 = h * h + dz * dz, r = std::sqrt(r2);
        // light arrives along (z - 4, -h) / r and leaves along -z
        const double cosine = -(z - 4) / r;
        expected += sigma * albedo * henyeyGreenstein(g, cosine) * std::exp(-sigma * (z - 2 + r)) / r2 * 4 / kSteps;
      }
      RenderRequest r;
      r.rib = orthographic(16, 0.004, 1024) + unbiased(1) +
              "WorldBegin\nAttributeBegin Translate 0.8 0 4\nLight \"PointLight\" \"l\" \"float intensity\" "
              "[1]\nAttributeEnd\n" +
              medium("\"color diffuseColor\" [0.7 0.7 0.7] \"float densityFloat\" [" + std::to_string(sigma) +
                     "] \"float anisotropy\" [" + std::to_string(g) + "]") +
              box(2, 6) + "WorldEnd\n";
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      // the light's own radiant intensity, from a plane that it shines on head on
      RenderRequest plain;
      plain.rib = orthographic(16, 0.004, 16) + unbiased(0) +
                  "WorldBegin\nAttributeBegin Translate 0 0 4\nLight \"PointLight\" \"l\" \"float intensity\" "
                  "[1]\nAttributeEnd\nBxdf \"PxrDiffuse\" \"d\" \"color diffuseColor\" [1 1 1]\n"
                  "Polygon \"P\" [-9 -9 5  9 -9 5  9 9 5  -9 9 5]\nWorldEnd\n";
      SceneRender floor(plain);
      ASSERT_TRUE(floor.ok());
      const double intensity = overPixels(floor.channel("Ci")).mean() * kPi;
      const auto m = overPixels(render.channel("Ci"));
      SCOPED_TRACE(std::string("sigma ") + std::to_string(sigma) + " g " + std::to_string(g));
      EXPECT_MEAN(m, expected * intensity, 0.02 * expected * intensity);
    }
}

// Of an isotropic half space under an even sky: 1 - sqrt(1 - albedo) H(mu) (Chandrasekhar 1960, section 85).
// H(mu) = 1 / (sqrt(1 - albedo) + albedo / 2 integral of x H(x) / (mu + x) over 0..1), by iteration from 1.
double hFunction(double albedo, double mu) {
  constexpr int kNodes = 400;
  std::vector<double> h(kNodes, 1.0);
  const auto at = [&](double m) {
    double sum = 0;
    for (int k = 0; k < kNodes; ++k) {
      const double x = (k + 0.5) / kNodes;
      sum += x * h[size_t(k)] / (m + x);
    }
    return 1 / (std::sqrt(1 - albedo) + albedo / 2 * sum / kNodes);
  };
  for (int round = 0; round < 60; ++round) {
    std::vector<double> next(kNodes);
    for (int k = 0; k < kNodes; ++k) next[size_t(k)] = at((k + 0.5) / kNodes);
    h = next;
  }
  return at(mu);
}
TEST(Media, AHalfSpaceReflectsWhatChandrasekharSays) {
  for (const double albedo : {0.5, 0.9})
    for (const double degrees : {0.0, 60.0}) {
      const double mu = std::cos(degrees * kPi / 180);
      RenderRequest r;
      r.rib = orthographic(32, 0.5, 64) + unbiased(400) + "WorldBegin\n" + kSky +
              medium("\"color diffuseColor\" " + numbers({albedo, albedo, albedo}) + " \"int multiScatter\" [1]") +
              "Translate 0 0 40\nRotate " + std::to_string(degrees) +
              " 1 0 0\nVolume \"box\" [-900 900 -900 900 0 60] [0 0 0]\nWorldEnd\n";
      SceneRender render(r);
      ASSERT_TRUE(render.ok());
      const double expected = 1 - std::sqrt(1 - albedo) * hFunction(albedo, mu);
      SCOPED_TRACE(std::string("albedo ") + std::to_string(albedo) + " at " + std::to_string(degrees));
      EXPECT_MEAN(overPixels(render.channel("Ci")), expected, 0.005);
    }
}

TEST(Media, OfAlbedoOneVanish) {
  const std::string white = "\"color diffuseColor\" [1 1 1] \"int multiScatter\" [1] ";
  const std::string ball = "AttributeBegin Translate 0 0 5 Sphere 1 -1 1 360 AttributeEnd\n";
  const std::string cells = "[3 2 2] \"varying float density\" [0 1 9 4 0 2 5 3 0 1 0 7]";
  for (const auto& [name, scene] : std::vector<std::pair<std::string, std::string>>{
           {"thin", medium(white) + ball},
           {"dense", medium(white + "\"float densityFloat\" [8]") + ball},
           {"channels apart", medium(white + "\"color densityColor\" [0.5 2 5]") + ball},
           {"two lobes",
            medium(white + "\"float anisotropy\" [0.8] \"float anisotropy2\" [-0.6] \"float blendFactor\" [0.4]") +
                ball},
           {"inside out", "ReverseOrientation\n" + medium(white + "\"float densityFloat\" [3]") + ball},
           {"uneven", medium(white + "\"string densityFloatPrimVar\" [\"density\"]") +
                          "Volume \"box\" [-1 1 -1 1 4 6] " + cells + "\n"},
           {"overlap", medium(white + "\"color densityColor\" [0.5 2 5]") + ball +
                           medium(white + "\"string densityFloatPrimVar\" [\"density\"]") +
                           "Volume \"box\" [-0.5 0.7 -1 1 4 6] " + cells +
                           "\nVolume \"ellipsoid\" [-1 0.4 -0.5 1 4.5 7] [0 0 0]\n"},
           {"moving", medium(white + "\"float densityFloat\" [3]") +
                          "AttributeBegin MotionBegin [0 1] Translate 0 0 5 Translate 0.7 0 5 MotionEnd Sphere 1 -1 "
                          "1 360 AttributeEnd\n"},
           {"scaled and sheared",
            medium(white + "\"string densityFloatPrimVar\" [\"density\"]") +
                "AttributeBegin Translate 0 0 5 Rotate 30 1 1 0 Scale 2 0.7 1 Volume \"box\" [-0.5 0.5 -1 1 -1 1] " +
                cells + " AttributeEnd\n"},
           {"around the camera", medium(white) + "Sphere 4 -4 4 360\n"}}) {
    RenderRequest r;
    r.rib =
        orthographic(24, 0.7, 64) + "Shutter 0 1\n" + unbiased(600) + "WorldBegin\n" + kSky + scene + "WorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    const image::Image seen = render.channel("Ci");
    for (int c = 0; c < 3; ++c) {
      const auto m = overPixels(seen, c);
      EXPECT_NEAR(m.mean(), 1, 0.005 + 3 * m.standardError())
          << name << "; picture: " << SceneRender::keep(seen, "media");
      EXPECT_LT(m.standardError(), name == "channels apart" || name == "overlap" ? 0.012 : 0.006) << name;
    }
  }
}

// Smoke in a ball of glass: nothing is lost of refraction, nor where boundaries coincide; and glass that absorbs takes
// what its depth takes, with the smoke that the light was scattered by in it.
TEST(Media, InsideGlassVanish) {
  const std::string glass =
      "Bxdf \"PxrSurface\" \"g\" \"float diffuseGain\" [0] \"float refractionGain\" [1] \"float reflectionGain\" "
      "[1] \"float glassRoughness\" [0] \"float glassIor\" [1.5]\nAttributeBegin Translate 0 0 5 Sphere 1 -1 1 360 "
      "AttributeEnd\n";
  for (const char* radius : {"0.8", "1"}) {
    RenderRequest r;
    r.rib = orthographic(24, 0.7, 64) + unbiased(600) + "WorldBegin\n" + kSky + glass +
            medium("\"color diffuseColor\" [1 1 1] \"int multiScatter\" [1] \"float densityFloat\" [2]") +
            "AttributeBegin Translate 0 0 5 Sphere " + radius + " -" + radius + " " + radius +
            " 360 AttributeEnd\nWorldEnd\n";
    SceneRender render(r);
    ASSERT_TRUE(render.ok());
    const auto m = overPixels(render.channel("Ci"));
    EXPECT_NEAR(m.mean(), 1, 0.005 + 3 * m.standardError()) << radius;
    EXPECT_LT(m.standardError(), 0.006);
  }
}

// Light samples and light found by chance are two roads to the same light, of every kind, through fog.
TEST(Media, AreLitAlikeBySamplesAndByChance) {
  for (const auto& [name, light] : std::vector<std::pair<std::string, std::string>>{
           {"rect",
            "Translate 0 2 4 Rotate -90 1 0 0 Scale 3 3 3 Light \"PxrRectLight\" \"l\" \"float intensity\" [5]"},
           {"sphere", "Translate 0 1.5 4 Light \"PxrSphereLight\" \"l\" \"float intensity\" [5]"},
           {"mesh",
            "Light \"PxrMeshLight\" \"l\" \"float intensity\" [3] Polygon \"P\" [-2 2 2  2 2 2  2 2.5 6  -2 2.5 6]"},
           {"dome", "Light \"PxrDomeLight\" \"l\" \"float intensity\" [1]"},
           {"sun", "Light \"PxrDistantLight\" \"l\" \"float intensity\" [1] \"float angleExtent\" [90]"}}) {
    const auto mean = [&, &light = light](int samples) {
      RenderRequest r;
      r.rib = orthographic(16, 0.5, 256) + unbiased(3, "\"int numLightSamples\" [" + std::to_string(samples) + "]") +
              "WorldBegin\nAttributeBegin Attribute \"visibility\" \"int camera\" [0]\n" + light +
              "\nAttributeEnd\n" +
              medium(
                  "\"color diffuseColor\" [0.9 0.8 0.7] \"int multiScatter\" [1] \"color densityColor\" [0.3 0.4 "
                  "0.6] \"float anisotropy\" [0.3]") +
              box(1, 7) +
              "Bxdf \"PxrDiffuse\" \"f\"\nAttributeBegin Translate 0 -0.8 4 Sphere 0.5 -0.5 0.5 360 AttributeEnd\n"
              "WorldEnd\n";
      return overSeeds(r, 8);
    };
    SCOPED_TRACE(name);
    EXPECT_SAME_MEAN(mean(1), mean(0), 0.02);
  }
}

TEST(Media, ScatterOnceUnlessTheySayOtherwise) {
  const auto mean = [](const char* more) {
    return overPixels(
               picture(orthographic(24, 0.5, 64) + unbiased(60) + "WorldBegin\n" + kSky +
                       medium(std::string("\"color diffuseColor\" [1 1 1] \"float densityFloat\" [2] ") + more) +
                       "AttributeBegin Translate 0 0 5 Sphere 1 -1 1 360 AttributeEnd\nWorldEnd\n"))
        .mean();
  };
  const double once = mean(""), often = mean("\"int multiScatter\" [1]");
  EXPECT_NEAR(often, 1, 0.01);
  EXPECT_LT(once, 0.7);
  EXPECT_GT(once, 0.1);
}

// No closed surface is taken for an open one, whatever its seams, poles and tessellation.
TEST(Media, ClosedSurfacesAreNotCalledOpen) {
  for (const std::string shape :
       {"Sphere 1 -1 1 360", "Torus 1 0.3 0 360 360", "Scale 1e-3 1 1e3 Sphere 1 -1 1 360",
        "Translate 1e5 0 0 Sphere 1 -1 1 360", "Volume \"box\" [-1 1 -1 1 -1 1] [0 0 0]",
        "PointsPolygons [3 3 3 3] [0 2 1  0 1 3  1 2 3  2 0 3] \"P\" [0 0 0  1 0 0  0 1 0  0 0 1]",
        "SubdivisionMesh \"catmull-clark\" [4 4 4 4 4 4] [0 1 3 2  2 3 5 4  4 5 7 6  6 7 1 0  1 7 5 3  6 0 2 4] [] "
        "[] [] [] "
        "\"P\" [-1 -1 1  1 -1 1  -1 1 1  1 1 1  -1 1 -1  1 1 -1  -1 -1 -1  1 -1 -1]"}) {
    RenderRequest r;
    r.rib = orthographic(4, 0.5, 1) + unbiased(1) + "WorldBegin\n" + kSky + medium("") + "Translate 0 0 5 " + shape +
            "\nWorldEnd\n";
    SceneRender render(r);
    EXPECT_TRUE(render.ok()) << shape;
    for (const std::string& m : render.messages()) EXPECT_EQ(m.find("MEDIUM-OPEN"), std::string::npos) << m;
  }
}

TEST(Media, BadInputIsToldAndBounded) {
  const auto messages = [](const std::string& world, const char* code) {
    RenderRequest r;
    r.rib = orthographic(8, 0.5, 4) + unbiased(4) + "WorldBegin\n" + kSky + world + "WorldEnd\n";
    SceneRender render(r);
    EXPECT_TRUE(render.ok()) << world;
    if (!render.ok()) return;
    const image::Image seen = render.channel("Ci");
    for (const float x : seen.pixels) EXPECT_TRUE(std::isfinite(x)) << world;
    bool isTold = !*code;
    for (const std::string& m : render.messages()) isTold |= m.find(code) != std::string::npos;
    EXPECT_TRUE(isTold) << world << (render.messages().empty() ? "" : render.messages()[0]);
  };
  messages("Bxdf \"PxrDiffuse\" \"d\"\n" + box(2, 3), "MEDIUM-NONE");
  messages(medium("") + "Volume \"box\" [0 0 0 1 0 1] [0 0 0]\n", "GEOM-VOLUME");
  messages(medium("") + "Volume \"torus\" [-1 1 -1 1 2 3] [0 0 0]\n", "GEOM-VOLUME");
  messages(medium("") + box(2, 3, "[2 2 2] \"varying float density\" [1 2 3]"), "MEDIUM-FIELD");
  messages(medium("") + "Points \"P\" [0 0 3] \"constant float constantwidth\" [1]\n", "MEDIUM-OPEN");
  messages(medium("") + "Polygon \"P\" [-1 -1 3 1 -1 3 1 1 3 -1 1 3]\n", "MEDIUM-OPEN");
  messages(medium("") + "Translate 0 0 3 Sphere 1 -1 0.3 360\n", "MEDIUM-OPEN");
  messages(medium("") + "Translate 0 0 3 Cylinder 1 -1 1 360\n", "MEDIUM-OPEN");
  messages(medium("") + "SolidBegin \"primitive\" Translate 0 0 3 Sphere 1 -1 1 360 SolidEnd\n", "MEDIUM-SOLID");
  messages(medium("\"float densityFloat\" [-4]") + box(2, 3), "");
  messages(medium("\"float densityFloat\" [1e30]") + box(2, 3), "");
  messages(medium("\"float densityFloat\" [1e12] \"int multiScatter\" [1]") + box(2, 3), "");
  messages(medium("\"color diffuseColor\" [4 4 4] \"int multiScatter\" [1]") + box(2, 3), "");
  messages(medium("\"string densityFloatPrimVar\" [\"nothing\"]") + box(2, 3), "");
  messages(
      medium("\"string densityFloatPrimVar\" [\"density\"]") + box(2, 3, "[1 1 1] \"varying float density\" [3]"),
      "");
  messages(medium("\"string densityFloatPrimVar\" [\"density\"] \"float maxDensity\" [0.5]") +
               box(2, 3, "[2 1 1] \"varying float density\" [3 9]"),
           "MEDIUM-BOUND");
  // open, and a medium in itself
  messages(medium("") + "Polygon \"P\" [-1 -1 3  1 -1 3  1 1 3  -1 1 3]\n" + box(2, 3) + box(2, 3), "");
  messages(medium("") + "AttributeBegin Scale 1 1 0\n" + box(2, 3) + "AttributeEnd\n", "");
}

}  // namespace
}  // namespace kinora::tests
