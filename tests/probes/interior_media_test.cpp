// Glass whose inside scatters (PxrSurface: ssAlbedo, volumeGlow) is glass and, of the same shape, a medium: pictures equal
// those of scenes that say so in two objects, bit for bit, for objects, instances, parameters that patterns feed, and
// after edits. What only absorbs has none, nor has what encloses nothing. That paths in glass and fog are right
// vcm_media_test.cpp and media_test.cpp show.
#include <cmath>

#include "tests/probes/probe_support.h"
#include "tests/probes/rooms.h"

namespace kinora::probes {
namespace {

std::string cloudyGlass(const std::string& inside) {
  return "    Bxdf \"PxrSurface\" \"glass\" \"float diffuseGain\" [0] \"float refractionGain\" [1] \"float "
         "reflectionGain\" "
         "[1] \"float glassRoughness\" [0] \"float glassIor\" [1.4] " +
         inside + "\n";
}
const char* const kBall = "    Sphere 0.35 -0.35 0.35 360\n";
std::string at(const std::string& place, const std::string& body) {
  return "  AttributeBegin\n    Translate " + place + "\n" + body + "  AttributeEnd\n";
}
std::string roomWith(const std::string& objects) { return room(kRect, kGrey, "", objects); }

std::unique_ptr<render::Renderer> rendered(Workshop& stage, const std::string& text) {
  render::Settings s;
  s.threads = 1;
  s.sets = {{"integrator.maxIndirectBounces", "6"}};
  auto r = stage.load(sceneOf(text, stage.messages), s);
  EXPECT_EQ(r->renderFilm(), render::Outcome::Complete) << stage.said;
  return r;
}
std::vector<int64_t> filmOf(const std::string& text, std::string* said = nullptr) {
  Workshop stage;
  const auto state = stateOf(rendered(stage, text)->film());
  if (said) *said = stage.said;
  return state;
}

const std::string kInside =
    "\"color extinction\" [2 3 4] \"color ssAlbedo\" [0.9 0.8 0.7] \"float g\" [0.4] \"float g1\" "
    "[-0.2] \"float blend\" [0.3] \"int multiScatter\" [1] \"color volumeGlow\" [0.1 0 0]";
const std::string kSameInside =
    "    Bxdf \"PxrVolume\" \"inside\" \"color densityColor\" [2 3 4] \"color diffuseColor\" [0.9 "
    "0.8 0.7] \"float anisotropy\" [0.4] \"float anisotropy2\" [-0.2] \"float blendFactor\" [0.3] "
    "\"int multiScatter\" [1] \"color emitColor\" [0.1 0 0]\n";

TEST(InteriorMedia, AreAnObjectOfTheirOwn) {
  const std::string place = "0.4 0.45 1.1";
  std::string said;
  const auto one = filmOf(roomWith(at(place, cloudyGlass(kInside) + kBall)), &said),
             two = filmOf(roomWith(at(place, cloudyGlass("") + kBall) + at(place, kSameInside + kBall))),
             clear = filmOf(roomWith(at(place, cloudyGlass("") + kBall)));
  EXPECT_EQ(said, "");
  EXPECT_TRUE(one == two);
  EXPECT_FALSE(one == clear);
}

TEST(InteriorMedia, OfInstances) {
  const auto placed = [](const std::string& object) {
    return roomWith("  ObjectBegin \"ball\"\n" + object + "  ObjectEnd\n" +
                    at("0.4 0.45 1.1", "    ObjectInstance \"ball\"\n") +
                    at("-0.7 0.45 0.6", "    Scale 0.7 0.9 0.7\n    ObjectInstance \"ball\"\n"));
  };
  const auto one = filmOf(placed(cloudyGlass(kInside) + kBall)),
             two = filmOf(placed(cloudyGlass("") + kBall + kSameInside + kBall));
  EXPECT_TRUE(one == two);
}

TEST(InteriorMedia, ThatPatternsFeed) {
  const std::string place = "0.4 0.45 1.1",
                    noise =
                        "    Pattern \"PxrFractal\" \"n\" \"float frequency\" [3]\n    Pattern \"PxrToFloat3\" \"c\" "
                        "\"reference float input\" [\"n:resultF\"]\n";
  const auto one = filmOf(roomWith(at(
                 place,
                 noise + cloudyGlass("\"reference color extinction\" [\"c:resultRGB\"] \"color ssAlbedo\" [1 1 1]") +
                     kBall))),
             two = filmOf(roomWith(at(place, cloudyGlass("") + kBall) +
                                   at(place, noise +
                                                 "    Bxdf \"PxrVolume\" \"inside\" \"reference color densityColor\" "
                                                 "[\"c:resultRGB\"]\n" +
                                                 kBall)));
  EXPECT_TRUE(one == two);
}

// Light that goes straight through a slab of it: what is left is what Beer and Lambert say, as if it only absorbed.
TEST(InteriorMedia, LetThroughWhatAbsorptionDoes) {
  const auto skyThrough = [](const std::string& inside) {
    Workshop stage;
    const auto r = rendered(
        stage,
        "Format 16 16 1\nPixelFilter \"box\" 1 1\nHider \"raytrace\" \"int maxsamples\" [64]\nDisplay \"x.exr\" "
        "\"openexr\" \"Ci\"\nScreenWindow -0.01 0.01 -0.01 0.01\nProjection \"orthographic\"\nIntegrator "
        " \"PxrPathTracer\" \"i\"\nWorldBegin\nLight \"PxrDomeLight\" "
        "\"sky\"\n"
        "Translate 0 0 4\nScale 1 1 0.5\nBxdf \"PxrSurface\" \"g\" \"float diffuseGain\" [0] \"float "
        "refractionGain\" "
        "[1] \"float glassRoughness\" [0] \"float glassIor\" [1] " +
            inside +
            "\nPointsPolygons [4 4 4 4 4 4] [0 1 2 3  7 6 5 4  0 4 5 1  1 5 6 2  2 6 7 3  3 7 4 0]\n"
            "\"vertex point P\" [-1 -1 -1 1 -1 -1 1 -1 1 -1 -1 1 -1 1 -1 1 1 -1 1 1 1 -1 1 1]\nWorldEnd\n");
    const image::Image picture = r->film().resolve(r->film().layout().find("Ci"));
    double sum = 0;
    for (const float x : picture.pixels) sum += x;
    return sum / double(picture.pixels.size());
  };
  // a way of one unit; nearly all of what is lost is absorbed
  EXPECT_NEAR(skyThrough("\"color extinction\" [0.8 0.8 0.8]"), std::exp(-0.8), 1e-3);
  EXPECT_NEAR(skyThrough("\"color extinction\" [0.8 0.8 0.8] \"color ssAlbedo\" [1e-6 1e-6 1e-6]"), std::exp(-0.8),
              0.015);
}

// What the scene leaves out is as the surface has it: no extinction, and nothing scattered of what only glows.
TEST(InteriorMedia, TakeTheSurfacesDefaults) {
  const std::string place = "-0.6 0.45 0.8";
  const auto of = [&](const std::string& inside) { return filmOf(roomWith(at(place, cloudyGlass(inside) + kBall))); };
  const auto two = [&](const std::string& medium) {
    return filmOf(roomWith(at(place, cloudyGlass("") + kBall) +
                           at(place, "    Bxdf \"PxrVolume\" \"inside\" " + medium + "\n" + kBall)));
  };
  EXPECT_TRUE(of("\"color ssAlbedo\" [1 1 1]") == two("\"color densityColor\" [0 0 0]"));
  EXPECT_TRUE(of("\"color volumeGlow\" [.5 .2 0] \"color extinction\" [1 1 1]") ==
              two("\"color diffuseColor\" [0 0 0] \"color emitColor\" [.5 .2 0]"));
}

// LamaDielectric by itself, as a root's slab and under a coat: what is lost by absorptionColor after absorptionRadius is
// scattered once by the share of scatterColor.
TEST(InteriorMedia, OfLamaDielectric) {
  const std::string place = "-0.6 0.45 0.8", slab = "    Bxdf \"LamaDielectric\" \"glass\" \"float roughness\" [0] ",
                    root = "    Bxdf \"LamaSurface\" \"root\" \"reference bxdf materialFront\" [\"NAME\"]\n",
                    coat =
                        "    Bxdf \"LamaSheen\" \"coat\"\n    Bxdf \"LamaLayer\" \"coated\" \"reference bxdf "
                        "materialTop\" [\"coat\"] \"reference bxdf materialBase\" [\"glass\"]\n";
  const std::string inside =
                        "\"color absorptionColor\" [0.5 0.3 0.1] \"float absorptionRadius\" [0.4] \"color "
                        "scatterColor\" [0.9 0.8 0.7] \"float scatterAnisotropy\" [0.4]\n",
                    medium =
                        "    Bxdf \"PxrVolume\" \"inside\" \"color transmittanceColor\" [0.5 0.3 0.1] \"float "
                        "transmittanceDistance\" [0.4] \"color diffuseColor\" [0.9 0.8 0.7] \"float anisotropy\" "
                        "[0.4]\n" +
                        std::string(kBall);
  const auto under = [&](const char* name) { return std::string(root).replace(root.find("NAME"), 4, name); };
  for (const std::string& more : {std::string(), under("glass"), coat, coat + under("coated")}) {
    std::string said;
    const auto one = filmOf(roomWith(at(place, slab + inside + more + kBall)), &said),
               two = filmOf(roomWith(at(place, slab + "\n" + more + kBall) + at(place, medium)));
    EXPECT_EQ(said, "") << more;
    EXPECT_TRUE(one == two) << more;
    EXPECT_FALSE(one == filmOf(roomWith(at(place, slab + "\n" + more + kBall)))) << more;
  }
}

// The extinction of PxrVolume by what is left after a distance.
TEST(InteriorMedia, TransmittanceIsWhatIsLeftAfterADistance) {
  const auto of = [&](const std::string& medium) {
    return filmOf(roomWith(at("-0.6 0.45 0.8", "    Bxdf \"PxrVolume\" \"v\" " + medium + "\n" + kBall)));
  };
  const auto half = of("\"color transmittanceColor\" [0.25 0.25 0.25] \"float transmittanceDistance\" [0.5]");
  EXPECT_TRUE(half == of("\"color transmittanceColor\" [0.0625 0.0625 0.0625] \"float transmittanceDistance\" [1]"));
  EXPECT_TRUE(half == of("\"color densityColor\" [2.7725887 2.7725887 2.7725887]"));
  EXPECT_FALSE(half == of("\"color densityColor\" [0 0 0]"));
  EXPECT_TRUE(of("\"float transmittanceDistance\" [0]") == of("\"color densityColor\" [0 0 0]"));
  EXPECT_TRUE(of("\"float transmittanceDistance\" [1]") == of("\"color densityColor\" [0 0 0]")) << "white is all";
}

TEST(InteriorMedia, WhereNothingIsEnclosedThereIsNone) {
  const std::string place = "0.4 0.45 1.1";
  const auto filmWith = [&](const std::string& more) {
    return filmOf(roomWith(at(place, cloudyGlass(more) + kBall)));
  };
  EXPECT_TRUE(filmWith("\"int thinGlass\" [1] " + kInside) == filmWith("\"int thinGlass\" [1]"));
  const std::string closed = "    Bxdf \"PxrSurface\" \"m\" ";
  EXPECT_TRUE(filmOf(roomWith(at(place, closed + kInside + "\n" + kBall))) ==
              filmOf(roomWith(at(place, closed + "\n" + kBall))));
}

TEST(InteriorMedia, FollowEdits) {
  Workshop stage;
  const std::string place = "0.4 0.45 1.1";
  const auto r = rendered(stage, roomWith(at(place, cloudyGlass(kInside) + kBall)));
  const auto cloudy = stateOf(r->film());
  scene::PrimitivePtr ball;
  for (const auto& p : r->scene().primitives)
    if (p->attributes->bxdf && p->attributes->bxdf->terminal->params.find("ssAlbedo")) ball = p;
  ASSERT_TRUE(ball);
  const auto renderAgain = [&] {
    EXPECT_TRUE(r->update()) << stage.said;
    EXPECT_EQ(r->renderFilm(), render::Outcome::Complete);
    render::Settings s;
    s.threads = 1;
    s.sets = {{"integrator.maxIndirectBounces", "6"}};
    const auto fresh = stage.load(r->scene(), s);
    EXPECT_EQ(fresh->renderFilm(), render::Outcome::Complete);
    EXPECT_TRUE(stateOf(r->film()) == stateOf(fresh->film()));
    return stateOf(r->film());
  };
  // clear, and cloudy once more
  auto clear = std::make_shared<scene::Attributes>(*ball->attributes);
  auto network = std::make_shared<scene::Network>(*clear->bxdf);
  auto node = std::make_shared<scene::Node>(*network->terminal);
  for (const char* name : {"extinction", "ssAlbedo", "volumeGlow"}) node->params.erase(name);
  network->terminal = node;
  clear->bxdf = network;
  ASSERT_TRUE(r->scene().setPrimitiveAttributes(ball->id, clear));
  EXPECT_TRUE(renderAgain() == filmOf(roomWith(at(place, cloudyGlass("") + kBall))));
  ASSERT_TRUE(r->scene().setPrimitiveAttributes(ball->id, ball->attributes));
  EXPECT_TRUE(renderAgain() == cloudy);
  // and moved, with what fills it
  scene::Matrix m;
  m.setTranslation(Imath::V3d(-0.25, 0, 0));
  ASSERT_TRUE(r->scene().setPrimitiveTransform(ball->id, scene::concat(ball->toWorld, scene::Transform::fixed(m))));
  EXPECT_FALSE(renderAgain() == cloudy);
}

}  // namespace
}  // namespace kinora::probes
