// What single things' digests see: every field that counts but the attributes; for a frame's own fields every one but
// numbers of edits and things. Remembered digests are those that a scene has without.
#include "scene/digests.h"

#include <gtest/gtest.h>

#include "scene/edits_testing.h"
#include "scene/identity.h"

namespace kinora::scene {
namespace {

using test::Edits;
using test::filledScene;

TEST(Digests, OfOneThingSeeEveryFieldButTheAttributes) {
  const Scene base = filledScene();
  Edits edits(base);
  size_t primitives = 0, lights = 0, networks = 0;
  for (size_t i = 0; i < edits.sites().size(); ++i) {
    const std::string& path = edits.sites()[i].path;
    const auto is = [&](const char* start) { return path.starts_with(start); };
    const bool isOwn = path.find(": attributes") == std::string::npos;
    SCOPED_TRACE(path);
    if (is("primitives[2]: ")) {
      const Scene s = edits.edited(i);
      EXPECT_EQ(ownDigestOf(*s.primitives[2]) != ownDigestOf(*base.primitives[2]), edits.sites()[i].counts && isOwn);
      ++primitives;
      if (is("primitives[2]: attributes: material: ")) {
        const NetworkPtr &a = s.primitives[2]->attributes->bxdf, &b = base.primitives[2]->attributes->bxdf;
        EXPECT_EQ(digestOf(*a) != digestOf(*b), edits.sites()[i].counts);
        ++networks;
      }
    } else if (is("lights[0]: ")) {
      // the geometry of a light comes with its attributes; an id of geometry says which object it is
      if (path.find("geometry") != std::string::npos) continue;
      EXPECT_EQ(ownDigestOf(edits.edited(i).lights[0]) != ownDigestOf(base.lights[0]),
                edits.sites()[i].counts && isOwn);
      ++lights;
    }
  }
  EXPECT_GT(primitives, 100u);
  EXPECT_GT(networks, 20u);
  EXPECT_GT(lights, 50u);
}

TEST(Digests, OfAFrameSeeItsOwnFieldsAndNoThing) {
  const Scene base = filledScene();
  Edits edits(base);
  const Digest before = frameDigestOf(base);
  size_t seen = 0;
  for (size_t i = 0; i < edits.sites().size(); ++i) {
    const std::string& path = edits.sites()[i].path;
    const std::string field = path.substr(0, path.find_first_of(":["));
    bool isThing = false;
    for (const char* name :
         {"cameras", "primitives", "objects", "instances", "lights", "light sources", "coordinate system", "next id"})
      isThing |= field.starts_with(name);
    SCOPED_TRACE(path);
    EXPECT_EQ(frameDigestOf(edits.edited(i)) != before, !isThing);
    seen += !isThing;
  }
  EXPECT_GT(seen, 200u);
}

TEST(Digests, OfNetworksAreRememberedWithThem) {
  NetworkDigests digests;
  auto network = std::make_shared<Network>();
  const Digest empty = digestOf(*network);
  EXPECT_EQ(digests.of(network), empty);
  EXPECT_EQ(digests.of(nullptr), Digest());
  for (int round = 0; round < 100; ++round) {
    // at the address of one that is gone, if it were gone
    auto other = std::make_shared<Network>();
    auto node = std::make_shared<Node>();
    node->handle = std::to_string(round);
    other->terminal = node;
    const NetworkPtr shared = std::move(other);
    EXPECT_EQ(digests.of(shared), digestOf(*shared));
    if (round % 3 == 0) digests.forgetOthers();
  }
}

TEST(Digests, OfPrimitivesAreRememberedBetweenScenes) {
  const Scene base = filledScene();
  Edits edits(base);
  PrimitiveDigests remembered;
  EXPECT_EQ(digestOf(base, {}, &remembered), digestOf(base));
  EXPECT_FALSE(remembered.known.empty());
  Scene s = base;
  for (size_t i = 0; i < edits.sites().size(); i += 37) {
    // now the scene of before, now the edited one
    if (i % 2) s = base;
    s = edits.edited(i % 3 ? base : s, i % 3 ? i : 0);
    SCOPED_TRACE(edits.sites()[i].path);
    EXPECT_EQ(digestOf(s, {}, &remembered), digestOf(s));
    const ContentsByName files{{s.primitives[0]->primvars.begin()->strings.empty()
                                    ? std::string("none")
                                    : s.primitives[0]->primvars.begin()->strings[0],
                                {1, 2}}};
    EXPECT_EQ(digestOf(s, files, &remembered), digestOf(s, files));
  }
}

}  // namespace
}  // namespace kinora::scene
