// Proves: the aperture that a Camera or a Hider describes is the one that blurs the picture: moments of a small
// bright ball out of focus, what is said of parameters that are not known, and that
// vignetting is in the pictures of all integrators. Misses: the lens itself, which is the
// projections' tests'.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

struct Blur {
  double x2 = 0, y2 = 0;  // in units of the lens's radius
  std::vector<std::string> messages;
};

// A lens of radius 0.2, sharp at 1, and a ball at 2: the lens point o moves its picture by o / 2 on the screen.
Blur blurOf(const std::string& camera, const std::string& hider = "") {
  RenderRequest r;
  r.rib =
      "Format 96 96 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [256] " + hider +
      "\nScreenWindow -.24 .24 -.24 .24\nProjection \"perspective\" \"fov\" [90]\nDepthOfField 1 .4 1\n" + camera +
      unbiased(0) +
      "WorldBegin\nBxdf \"PxrConstant\" \"c\" \"color emitColor\" [1 1 1]\nTranslate 0 0 2 Sphere .02 -.02 .02 360\n"
      "WorldEnd\n";
  SceneRender render(r);
  Blur b;
  b.messages = render.messages();
  if (!render.ok()) return b;
  const image::Image picture = render.channel("a");
  double all = 0;
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 96; ++x) {
      const double w = picture.pixels[size_t(y * 96 + x)], dx = (x + 0.5) / 200 - 0.24, dy = (y + 0.5) / 200 - 0.24;
      all += w;
      b.x2 += w * dx * dx;
      b.y2 += w * dy * dy;
    }
  b.x2 /= all * 0.01;
  b.y2 /= all * 0.01;
  return b;
}

TEST(Lens, TheCamerasApertureBlurs) {
  const double own = 0.01 * 0.01 / 4 / 0.01;  // of the ball and the pixels: a disk of radius .01 has <x^2> = r^2 / 4
  const auto expect = [&](const Blur& b, double x2, double y2) {
    EXPECT_NEAR(b.x2, x2 + own, 0.01) << x2;
    EXPECT_NEAR(b.y2, y2 + own, 0.01) << y2;
    for (const std::string& m : b.messages) EXPECT_EQ(m.find("PARAM"), std::string::npos) << m;
  };
  expect(blurOf(""), 0.25, 0.25);
  expect(blurOf("Camera \"c\" \"int apertureNSides\" [0] \"float apertureRoundness\" [0] \"float dofaspect\" [1]\n"),
         0.25, 0.25);
  expect(blurOf("Camera \"c\" \"float dofaspect\" [2]\n"), 0.0625, 0.25);
  expect(blurOf("Camera \"c\" \"int apertureNSides\" [4] \"float apertureRoundness\" [0]\n"), 1.0 / 6, 1.0 / 6);
  expect(blurOf("Camera \"c\" \"float apertureDensity\" [1]\n"), 0.3, 0.3);
  expect(blurOf("Camera \"c\" \"float apertureDensity\" [-1]\n"), 0.15, 0.15);
  expect(blurOf("", "\"float[4] aperture\" [4 0 0 0] \"float dofaspect\" [.5]"), 4.0 / 6, 1.0 / 6);
}

TEST(Lens, ParametersThatNobodyKnowsAreTold) {
  const auto count = [](const Blur& b, const std::string& text) {
    return std::count_if(b.messages.begin(), b.messages.end(),
                         [&](const std::string& m) { return m.find(text) != std::string::npos; });
  };
  const Blur b = blurOf(
      "Camera \"c\" \"int apertureSides\" [6] \"float[2] stereoplanedepths\" [1 2] "
      "\"int extremeoffset\" [0] \"float nearClip\" [.1] \"float farClip\" [100] \"string __id\" [\"x\"]\n");
  EXPECT_EQ(count(b, "has no parameter 'apertureSides'"), 1);
  EXPECT_EQ(count(b, "apertureNSides"), 1) << "what may be meant";
  EXPECT_EQ(count(b, "'stereoplanedepths'"), 1);
  EXPECT_EQ(count(b, "PARAM-"), 2);
  EXPECT_EQ(count(blurOf("Camera \"c\" \"float fov\" [30]\n"), "has no parameter 'fov'"), 1);
}

// Vignetting is the camera's, whichever integrator follows its rays.
TEST(Lens, EveryIntegratorWeighsSamplesAsTheCameraDoes) {
  const auto edge = [](const std::string& integrator) {
    RenderRequest r;
    r.rib =
        "Format 17 17 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [4] \"int jitter\" [0]\n"
        "Projection \"PxrCamera\" \"float fov\" [60] \"float natural\" [1]\nIntegrator \"" +
        integrator +
        "\nWorldBegin\nBxdf \"PxrConstant\" \"c\" \"color emitColor\" [1 1 1]\nSphere 10 -10 10 360\nWorldEnd\n";
    SceneRender render(r);
    const image::Image picture = render.channel("Ci");
    return double(picture.at(0, 8)[0] / picture.at(8, 8)[0]);
  };
  const double expected = edge("PxrPathTracer\" \"i\"");
  EXPECT_LT(expected, 0.65);
  EXPECT_NEAR(edge("PxrDefault\" \"i\""), expected, 1e-4);
  EXPECT_NEAR(edge("PxrVisualizer\" \"i\" \"string style\" [\"flat\"]"), expected, 1e-4);
  EXPECT_NEAR(edge("PxrDirectLighting\" \"i\""), expected, 1e-4);
}

}  // namespace
}  // namespace kinora::tests
