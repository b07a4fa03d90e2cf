// Proves: PxrOcclusion against closed forms for each distribution, its distance limits, and against the path tracer
// under a white dome; PxrValidateBxdf shows a sound material's albedo and nothing else; PxrVisualizer's styles on a
// plane whose answer is known. Misses: how the edges of its wireframe look.
#include <gtest/gtest.h>

#include <cmath>

#include "support/render_scene.h"
#include "truth/scenes.h"

namespace kinora::tests {
namespace {

// A white plane at z = 1 seen at one point from z = 0, with something around it that the camera does not see.
std::string plane(const std::string& integrator, const std::string& around, int samples = 64) {
  return orthographic(16, 1e-4, samples) + integrator +
         "WorldBegin\nBxdf \"PxrDiffuse\" \"white\" \"color diffuseColor\" [0.5 0.5 0.5]\n" +
         "AttributeBegin Attribute \"visibility\" \"int camera\" [0]\n" + around +
         "AttributeEnd\nAttributeBegin Translate 0 0 1\nPolygon \"vertex point P\" [-50 -50 0  -50 50 0  50 50 0  50 "
         "-50 0] "
         "\"st\" [0 0  0 1  1 1  1 0]\nAttributeEnd\nWorldEnd\n";
}
std::string occlusion(const std::string& parameters) {
  return "Integrator \"PxrOcclusion\" \"i\" " + parameters + "\n";
}

void expectOpen(const std::string& parameters, const std::string& around, double expected) {
  RenderRequest r;
  r.rib = plane(occlusion(parameters), around);
  const testing::Moments m = overSeeds(r, 8);
  EXPECT_NEAR(m.mean(), expected, 3e-3 * expected + 4 * m.standardError()) << parameters;
  EXPECT_LE(m.standardError(), 2e-3) << parameters;
}

TEST(Occlusion, OfADiskOverhead) {
  // radius 0.8 at distance 0.6: 53.13 degrees off the normal, cosine 0.6
  const std::string disk = "Translate 0 0 0.4 Disk 0 0.8 360\n";
  expectOpen("\"int distribution\" [1]", disk, 0.36);
  expectOpen("\"int distribution\" [0]", disk, 0.6);
  expectOpen("\"int distribution\" [1] \"float cosineSpread\" [4]", disk, std::pow(0.6, 5));
  expectOpen("\"int distribution\" [2]", disk, 0.36);  // a diffuse material samples by the cosine
  expectOpen("\"int distribution\" [1] \"float maxDistance\" [0.5]", disk, 1);
  expectOpen("\"int distribution\" [1] \"int useAlbedo\" [1]", disk, 0.18);
  expectOpen("\"int numSamples\" [1]", disk, 0.36);
}

TEST(Occlusion, FallsOffWithDistance) {
  const std::string ball = "Translate 0 0 1 Sphere 0.7 -0.7 0.7 360\n";  // every direction meets it at 0.7
  expectOpen("\"float falloff\" [2]", ball, 1 - std::exp(-1.4));
  RenderRequest r;
  r.rib = plane(occlusion(""), ball, 4);
  EXPECT_EQ(overSeeds(r, 1).mean(), 0);
}

TEST(Occlusion, IsWhatAWhiteDomeLights) {
  const std::string things =
      "Translate 0.3 0.1 0.5 Sphere 0.3 -0.3 0.3 360 Translate -1 0 0.3 Sphere 0.4 -0.4 0.4 360\n";
  RenderRequest a, b;
  a.rib = plane(occlusion("\"int useAlbedo\" [1]"), things);
  b.rib = plane(unbiased(0), "Light \"PxrDomeLight\" \"d\" \"float intensity\" [1]\n" + things);
  EXPECT_SAME_MEAN(overSeeds(a, 12), overSeeds(b, 12), 0.003);
}

TEST(Occlusion, BadNumbersAreTamed) {
  RenderRequest r;
  r.rib = plane(
      occlusion(
          "\"int numSamples\" [-3] \"float maxDistance\" [-1] \"float falloff\" [-5] \"float cosineSpread\" [-2]"),
      "", 4);
  EXPECT_EQ(overSeeds(r, 1).mean(), 1);
}

TEST(ValidateBxdf, ASoundMaterialIsPureGreen) {
  RenderRequest r;
  r.rib = plane("Integrator \"PxrValidateBxdf\" \"i\" \"int numSamples\" [4]\n", "", 16);
  SceneRender render(r);
  ASSERT_TRUE(render.ok());
  const image::Image picture = render.channel("Ci");
  EXPECT_EQ(overPixels(picture, 0).mean(), 0);
  EXPECT_NEAR(overPixels(picture, 1).mean(), 0.5, 1e-4);
  EXPECT_EQ(overPixels(picture, 2).mean(), 0);
}

TEST(Visualizer, AMatCapWithoutAnImageIsTold) {
  RenderRequest r;
  r.rib = plane("Integrator \"PxrVisualizer\" \"i\" \"string style\" [\"matcap\"]\n", "", 4);
  SceneRender render(r);
  EXPECT_TRUE(says(render, "PARAM-IMAGE"));
}

TEST(Visualizer, StylesOfAPlane) {
  const auto show = [](const std::string& parameters, int component) {
    RenderRequest r;
    r.rib = plane("Integrator \"PxrVisualizer\" \"i\" \"int wireframe\" [0] " + parameters + "\n", "", 4);
    SceneRender render(r);
    EXPECT_TRUE(render.ok());
    return overPixels(render.channel("Ci"), component).mean();
  };
  EXPECT_NEAR(show("\"string style\" [\"shaded\"]", 0), 1, 1e-5) << "it faces the view";
  EXPECT_NEAR(show("\"string style\" [\"bxdf\"]", 0), 0.5, 1e-4);
  EXPECT_NEAR(show("\"string style\" [\"normals\"]", 2), -1, 1e-5);
  EXPECT_NEAR(show("\"string style\" [\"normals\"] \"int normalMap\" [1]", 0), 0.5, 1e-5);
  EXPECT_NEAR(show("\"string style\" [\"objectnormals\"]", 2), -1, 1e-5);
  EXPECT_NEAR(show("\"string style\" [\"st\"]", 1), 0.5, 1e-3);
  EXPECT_GT(show("\"string style\" [\"flat\"]", 1), 0.1);
  EXPECT_NEAR(show("\"string style\" [\"nonsense\"]", 0), 1, 1e-5) << "shaded stands in";
  RenderRequest r;
  r.rib = plane(
      "Integrator \"PxrVisualizer\" \"i\" \"float wireframeWidth\" [1e9] \"float wireframeOpacity\" [1] \"color "
      "wireframeColor\" [0 1 0]\n",
      "", 4);
  SceneRender wires(r);
  EXPECT_NEAR(overPixels(wires.channel("Ci"), 1).mean(), 1, 1e-5);
  EXPECT_NEAR(overPixels(wires.channel("Ci"), 0).mean(), 0, 1e-5);
}

}  // namespace
}  // namespace kinora::tests
