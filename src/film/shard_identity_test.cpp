// Proves that parts of scenes that differ in any two edits never merge and that the refusal names the difference, and
// that what names it survives the way through JSON. Misses what files hold: tests/identity.
#include "film/shard_identity.h"

#include <gtest/gtest.h>

#include <random>

#include "film/film_test_samples.h"
#include "scene/edits_testing.h"

namespace kinora::film {
namespace {

Shard partOf(const scene::Scene& scene, uint32_t sample) {
  ChannelLayout layout;
  layout.add(colorChannel("Ci"));
  Shard s;
  s.film = test::makeFilm(2, 2, layout, {0, 0, 2, 2});
  s.info.sceneHash = scene::digestOf(scene).str();
  s.info.inventory = inventoryFromJson(nlohmann::json::parse(inventoryToJson(scene::inventoryOf(scene)).dump()));
  s.info.ranges = {{sample, sample + 1}};
  return s;
}

TEST(ShardIdentity, PairsOfEditsNeverMerge) {
  const scene::Scene base = scene::test::filledScene(4);
  scene::test::Edits edits(base);
  const auto& sites = edits.sites();
  std::mt19937 rng(6);
  const auto any = [&] {
    size_t i;
    do i = rng() % sites.size();
    while (!sites[i].counts);
    return i;
  };
  for (int pair = 0; pair < 300; ++pair) {
    const size_t i = any(), j = any();
    SCOPED_TRACE(sites[i].path + " and " + sites[j].path);
    const scene::Scene a = edits.edited(i), b = edits.edited(j);
    Shard sum = partOf(a, 0);
    const Status s = addShard(sum, partOf(b, 1));
    if (i == j) {
      EXPECT_TRUE(s.ok()) << s.what;
      continue;
    }
    EXPECT_EQ(s.code, "FILM-SHARD-SCENE");
    EXPECT_NE(s.what.find("than the parts before it: "), std::string::npos);
    EXPECT_EQ(s.what.find("scene hashes"), std::string::npos) << "not named: " << s.what;
    EXPECT_EQ(sum.info.ranges.size(), 1u) << "nothing is changed";
  }
}

TEST(ShardIdentity, InventoriesAndFilesAreReadAsWritten) {
  const scene::Scene scene = scene::test::filledScene(5);
  for (const scene::InventorySize& size : {scene::InventorySize{}, scene::InventorySize{2, 5}}) {
    const scene::Inventory inventory = scene::inventoryOf(scene, {}, size);
    EXPECT_EQ(inventoryFromJson(nlohmann::json::parse(inventoryToJson(inventory).dump())).things, inventory.things);
  }
  const std::vector<FileContents::Entry> files{{"texture", "a\xff.tex", Digest{~0ull, 1}}, {"volume", "b", {}}};
  EXPECT_EQ(filesFromJson(nlohmann::json::parse(filesToJson(files).dump())), files);
}

TEST(ShardIdentity, FilesThatBothHaveMustHoldTheSame) {
  const scene::Scene scene;
  Shard a = partOf(scene, 0), b = partOf(scene, 1), c = partOf(scene, 2);
  a.info.lateFiles = {{"texture", "x.tex", digestOf("x")}};
  b.info.lateFiles = {{"volume", "y.vdb", digestOf("y")}};
  ASSERT_TRUE(addShard(a, b).ok()) << "each met another";
  EXPECT_EQ(a.info.lateFiles.size(), 2u);
  c.info.lateFiles = {{"volume", "y.vdb", digestOf("other")}};
  EXPECT_NE(addShard(a, c).what.find("volume \"y.vdb\" differs"), std::string::npos);
  c.info.lateFiles = {{"volume", "y.vdb", {}}};
  EXPECT_FALSE(addShard(a, c).ok()) << "not there on one machine";
  c.info.lateFiles = {{"volume", "y.vdb", digestOf("y")}};
  EXPECT_TRUE(addShard(a, c).ok());
}

// Tables that name what is not there, as a damaged file does.
TEST(ShardIdentity, BrokenTablesThrow) {
  for (const char* text : {R"({"names":[],"things":[["a","",1,[0,1]]]})", R"({"names":["a"],"things":[["a","",1]]})",
                           R"({"things":[]})", R"([1])"}) {
    EXPECT_THROW((void)inventoryFromJson(nlohmann::json::parse(text)), std::exception) << text;
  }
}

}  // namespace
}  // namespace kinora::film
