#include "shade/legacy_bxdfs.h"

#include <gtest/gtest.h>

namespace kinora::shade {
namespace {

scene::Parameter floats(const char* name, std::vector<float> values) {
  scene::Parameter p;
  p.name = name;
  p.type = values.size() == 3 ? scene::ValueType::Color : scene::ValueType::Float;
  p.floats = std::move(values);
  return p;
}

TEST(LegacyBxdfs, KeepsColoursRoughnessAndConnections) {
  scene::Node node;
  node.kind = "Bxdf";
  node.plugin = "PxrLMDiffuse";
  node.handle = "clay";
  node.params.set(floats("roughness", {0.5f}));
  node.params.set(floats("incandescence", {1, 2, 3}));
  scene::Parameter link;
  link.name = "frontColor";
  link.type = scene::ValueType::Color;
  link.isReference = true;
  link.strings = {"mix:resultRGB"};
  node.params.set(link);
  const std::optional<scene::Node> n = modernBxdfFor(node);
  ASSERT_TRUE(n);
  EXPECT_EQ(n->plugin, "PxrSurface");
  EXPECT_EQ(n->handle, "clay");
  EXPECT_EQ(n->params.getFloat("diffuseRoughness", 0), 0.5f);
  EXPECT_EQ(n->params.getFloats("glowColor"), (std::vector<float>{1, 2, 3}));
  EXPECT_EQ(n->params.getFloat("glowGain", 0), 1) << "a colour alone would not glow";
  const scene::Parameter* color = n->params.find("diffuseColor");
  ASSERT_TRUE(color && color->isReference);
  EXPECT_EQ(color->strings[0], "mix:resultRGB");
}

TEST(LegacyBxdfs, MetalsByColourAreArtisticOthersPhysical) {
  scene::Node node;
  node.plugin = "pxrlmMETAL";
  node.params.set(floats("eta", {0.2f, 0.4f, 1.3f}));
  EXPECT_EQ(modernBxdfFor(node)->params.getInt("specularFresnelMode", 0), 1);
  EXPECT_EQ(modernBxdfFor(node)->params.getFloats("specularIor"), (std::vector<float>{0.2f, 0.4f, 1.3f}));
  node.params.set(floats("specularColor", {1, 0.8f, 0.3f}));
  EXPECT_EQ(modernBxdfFor(node)->params.getInt("specularFresnelMode", 1), 0);
  EXPECT_EQ(modernBxdfFor(node)->params.getFloats("specularFaceColor"), (std::vector<float>{1, 0.8f, 0.3f}));
}

TEST(LegacyBxdfs, SkinsAreThreeProfiles) {
  for (const char* name : {"PxrSkin", "PxrLMSubsurface"}) {
    scene::Node node;
    node.plugin = name;
    node.params.set(floats("farColor", {0.8f, 0.2f, 0.1f}));
    node.params.set(floats("farLength", {12}));
    const std::optional<scene::Node> n = modernBxdfFor(node);
    ASSERT_TRUE(n);
    EXPECT_EQ(n->params.getInt("subsurfaceType", 0), 3);
    EXPECT_EQ(n->params.getFloat("diffuseGain", 1), 0);
    EXPECT_EQ(n->params.getFloats("longSubsurfaceColor"), (std::vector<float>{0.8f, 0.2f, 0.1f}));
    EXPECT_EQ(n->params.getFloat("longSubsurfaceDmfp", 0), 12);
    EXPECT_FLOAT_EQ(n->params.getFloat("longSubsurfaceGain", 0), 1.f / 3);
  }
}

TEST(LegacyBxdfs, OneEtaBecomesThreeAndStrangersGetNone) {
  scene::Node node;
  node.plugin = "PxrLMPlastic";
  node.params.set(floats("clearcoatEta", {1.4f}));
  EXPECT_EQ(modernBxdfFor(node)->params.getFloats("clearcoatIor"), (std::vector<float>{1.4f, 1.4f, 1.4f}));
  node.plugin = "NobodyKnows";
  EXPECT_FALSE(modernBxdfFor(node));
}

TEST(ColorPrimvarNetwork, FallsBackOnTheColorOfTheAttributes) {
  scene::Attributes a;
  a.color = {0.1f, 0.2f, 0.3f};
  const scene::NetworkPtr n = colorPrimvarNetwork(&a);
  ASSERT_EQ(n->patterns.size(), 1u);
  EXPECT_EQ(n->patterns[0]->params.getString("varname", ""), "Cs");
  EXPECT_EQ(n->patterns[0]->params.getFloats("defaultColor"), (std::vector<float>{0.1f, 0.2f, 0.3f}));
  EXPECT_EQ(n->terminal->params.find("diffuseColor")->strings[0], n->patterns[0]->handle + ":resultRGB");
}

}  // namespace
}  // namespace kinora::shade
