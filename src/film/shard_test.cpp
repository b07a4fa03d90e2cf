// Proves that shards keep every integer, that parts merge to the unsplit film bit for bit, and that cut, altered and
// contradictory files are refused. It misses EXR files that OpenEXR itself reads wrongly.
#include "film/shard.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "film/film_test_samples.h"
#include "base/folder_test.h"

namespace kinora::film {
namespace {

using test::everyReducer, test::makeFilm, test::randomSamples, test::sameState, test::Samples;

class ShardFile : public kinora::test::FolderTest {
 protected:
  static ShardInfo info(uint32_t begin, uint32_t end) {
    ShardInfo i;
    i.sceneHash = "abc";
    i.seed = 0xffffffffffffffffull;
    i.frame = 7;
    i.ranges = {{begin, end}};
    i.renderSeconds = 1.5;
    i.outputs = "{\"displays\":[]}";
    return i;
  }
  ChannelLayout layout_ = [] {
    ChannelLayout l = everyReducer();
    l.setNegative(-1, 0.25);
    Channel own = colorChannel("own", "Ci");
    own.filter = {"sinc", 4, 4};
    l.add(own);
    l.setNegative(0, 1.0 / 3);
    return l;
  }();
  Window window_{3, 2, 21, 19};
  Samples samples_ = randomSamples(layout_, window_, 6, 5);
  std::unique_ptr<Film> filmOf(uint32_t begin, uint32_t end) const {
    auto film = makeFilm(40, 30, layout_, window_);
    std::vector<int> order;
    for (int i = 0; i < samples_.size(); ++i)
      if (samples_.index[size_t(i)] >= begin && samples_.index[size_t(i)] < end) order.push_back(i);
    samples_.addTo(*film, order, 0, order.size());
    film->addSplatPasses(end - begin);
    return film;
  }
  static std::string bytesOf(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  static void put(const std::string& file, const std::string& bytes) {
    std::ofstream(file, std::ios::binary) << bytes;
  }
};

TEST_F(ShardFile, RoundTripKeepsEverything) {
  auto film = filmOf(0, 6);
  Samples bad(layout_.recordFloats());
  bad.add(4, 4, 2, 1, std::vector<float>(size_t(layout_.recordFloats()), NAN));
  bad.add(4, 4, 3, 1, std::vector<float>(size_t(layout_.recordFloats()), -1e30f));
  bad.addTo(*film);
  ASSERT_TRUE(writeShard(path("a.exr"), *film, info(0, 6)).ok());
  EXPECT_TRUE(isShard(path("a.exr")));
  Shard back;
  const Status s = readShard(path("a.exr"), back);
  ASSERT_TRUE(s.ok()) << s.what;
  EXPECT_TRUE(sameState(*film, *back.film));
  EXPECT_EQ(back.film->layout(), layout_);
  EXPECT_EQ(back.film->width(), 40);
  EXPECT_EQ(back.info.seed, 0xffffffffffffffffull);
  EXPECT_EQ(back.info.frame, 7);
  EXPECT_EQ(back.info.outputs, "{\"displays\":[]}");
  EXPECT_EQ(back.info.ranges, (std::vector<SampleRange>{{0, 6}}));
  const FilmCounters c = back.film->counters();
  EXPECT_EQ(c.nonFinite, 1u);
  ASSERT_EQ(c.bad.size(), 1u);
  EXPECT_TRUE(std::isnan(c.bad[0].value));
  EXPECT_EQ(c.saturated, film->counters().saturated);
  EXPECT_GT(c.saturated[0], 0u);
  EXPECT_EQ(c.negative, film->counters().negative);
}

TEST_F(ShardFile, MergedPartsEqualTheUnsplitFilmInAnyOrder) {
  const auto whole = filmOf(0, 6);
  ASSERT_TRUE(writeShard(path("a"), *filmOf(0, 1), info(0, 1)).ok());
  ASSERT_TRUE(writeShard(path("b"), *filmOf(1, 4), info(1, 4)).ok());
  ASSERT_TRUE(writeShard(path("c"), *filmOf(4, 6), info(4, 6)).ok());
  std::vector<std::string> names{path("a"), path("b"), path("c")};
  do {
    Shard merged;
    std::vector<std::string> warnings;
    const Status s = mergeShards(names, merged, warnings);
    ASSERT_TRUE(s.ok()) << s.what;
    EXPECT_TRUE(warnings.empty());
    EXPECT_TRUE(sameState(*merged.film, *whole));
    EXPECT_EQ(merged.info.ranges, (std::vector<SampleRange>{{0, 6}}));
    EXPECT_EQ(merged.info.renderSeconds, 4.5);
  } while (std::next_permutation(names.begin(), names.end()));
}

TEST_F(ShardFile, PartsThatDoNotBelongTogetherAreRefused) {
  ASSERT_TRUE(writeShard(path("a"), *filmOf(0, 3), info(0, 3)).ok());
  ASSERT_TRUE(writeShard(path("overlap"), *filmOf(2, 6), info(2, 6)).ok());
  ShardInfo other = info(3, 6);
  other.sceneHash = "abd";
  ASSERT_TRUE(writeShard(path("scene"), *filmOf(3, 6), other).ok());
  other = info(3, 6);
  other.seed = 1;
  ASSERT_TRUE(writeShard(path("seed"), *filmOf(3, 6), other).ok());
  other = info(3, 6);
  other.frame = 8;
  ASSERT_TRUE(writeShard(path("frame"), *filmOf(3, 6), other).ok());
  ASSERT_TRUE(writeShard(path("window"), *makeFilm(40, 30, layout_, {0, 0, 5, 5}), info(3, 6)).ok());
  ChannelLayout fewer;
  fewer.add(colorChannel("Ci"));
  ASSERT_TRUE(writeShard(path("channels"), *makeFilm(40, 30, fewer, window_), info(3, 6)).ok());
  const std::pair<const char*, const char*> table[] = {
      {"overlap", "FILM-SHARD-OVERLAP"}, {"scene", "FILM-SHARD-SCENE"}, {"seed", "FILM-SHARD-SEED"},
      {"frame", "FILM-SHARD-FRAME"},     {"window", "FILM-MERGE-SIZE"}, {"channels", "FILM-MERGE-CHANNELS"},
      {"missing", "FILM-SHARD-READ"},    {"a", "FILM-SHARD-OVERLAP"}};
  for (const auto& [name, code] : table) {
    Shard merged;
    std::vector<std::string> warnings;
    EXPECT_EQ(mergeShards({path("a"), path(name)}, merged, warnings).code, code) << name;
    EXPECT_FALSE(merged.film);
  }
}

TEST_F(ShardFile, AGapIsAWarning) {
  ASSERT_TRUE(writeShard(path("a"), *filmOf(1, 2), info(1, 2)).ok());
  ASSERT_TRUE(writeShard(path("b"), *filmOf(4, 6), info(4, 6)).ok());
  Shard merged;
  std::vector<std::string> warnings;
  ASSERT_TRUE(mergeShards({path("b"), path("a")}, merged, warnings).ok());
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_NE(warnings[0].find("0:1"), std::string::npos);
  EXPECT_NE(warnings[1].find("2:4"), std::string::npos);
}

TEST_F(ShardFile, CutFilesAreRefused) {
  ASSERT_TRUE(writeShard(path("a"), *filmOf(0, 6), info(0, 6)).ok());
  const std::string whole = bytesOf(path("a"));
  ASSERT_GT(whole.size(), 1000u);
  for (int i = 0; i < 40; ++i) {
    put(path("cut"), whole.substr(0, whole.size() * size_t(i) / 40));
    Shard shard;
    EXPECT_EQ(readShard(path("cut"), shard).code, "FILM-SHARD-READ") << i;
    EXPECT_FALSE(shard.film);
  }
}

// A flipped byte may hit pixels' zip data, the header or the description: anything but a crash will do.
TEST_F(ShardFile, AlteredFilesDoNotCrash) {
  ASSERT_TRUE(writeShard(path("a"), *filmOf(0, 6), info(0, 6)).ok());
  const std::string whole = bytesOf(path("a"));
  std::mt19937 rng(11);
  int refused = 0;
  for (int i = 0; i < 300; ++i) {
    std::string bytes = whole;
    // the first third holds the header and the description
    const size_t range = i % 2 ? bytes.size() : std::min<size_t>(bytes.size(), 6000);
    for (int k = 0; k < 1 + i % 3; ++k) bytes[rng() % range] = char(rng());
    put(path("altered"), bytes);
    Shard shard;
    const Status s = readShard(path("altered"), shard, uint64_t(1) << 26);
    EXPECT_EQ(s.ok(), shard.film != nullptr);
    refused += !s.ok();
  }
  EXPECT_GT(refused, 100);
}

TEST_F(ShardFile, DescriptionsThatLieAreRefused) {
  ASSERT_TRUE(writeShard(path("a"), *filmOf(0, 6), info(0, 6)).ok());
  const std::string whole = bytesOf(path("a"));
  // same length, so that the rest of the file stays in place
  const std::pair<std::string, std::string> lies[] = {{"\"window\":[3,2,21,19]", "\"window\":[3,2,22,19]"},
                                                      {"\"resolution\":[40,30]", "\"resolution\":[4e9,1]"},
                                                      {"\"resolution\":[40,30]", "\"resolution\":[-1,30]"},
                                                      {"\"version\":4", "\"version\":3"},
                                                      {"\"negativeLobes\":[0.25", "\"negativeLobes\":[null"},
                                                      {"\"negativeLobes\":[0.25", "\"negativeLobes\":[-1.5"},
                                                      {"\"samples\":[[0,6]]", "\"samples\":[[6,0]]"},
                                                      {"\"samples\":[[0,6]]", "\"samples\":[[0,0]]"},
                                                      {"\"stepLog2\":-30", "\"stepLog2\":-99"},
                                                      {"\"width\":3", "\"width\":1"},
                                                      {"\"width\":3", "\"width\":9"},
                                                      {"\"reducer\":3", "\"reducer\":9"},
                                                      {"\"channels\":[", "\"channelz\":["},
                                                      {"\"things\":[]", "\"thingz\":[]"},
                                                      {"\"lateFiles\":[]", "\"lateFiles\":12"},
                                                      {"\"seed\":1", "\"seed\":x"}};
  for (const auto& [truth, lie] : lies) {
    std::string bytes = whole;
    const size_t at = bytes.find(truth);
    ASSERT_NE(at, std::string::npos) << truth;
    bytes.replace(at, truth.size(), lie);
    put(path("lie"), bytes);
    Shard shard;
    EXPECT_FALSE(readShard(path("lie"), shard).ok()) << lie;
  }
}

TEST_F(ShardFile, APictureOrAFolderIsNoShard) {
  put(path("text"), "hello");
  Shard shard;
  EXPECT_FALSE(isShard(path("text")));
  EXPECT_FALSE(readShard(path("text"), shard).ok());
  EXPECT_FALSE(readShard(folder_.string(), shard).ok());
  EXPECT_FALSE(isShard(folder_.string()));
}

TEST_F(ShardFile, UnwritableTargetsGiveAnErrorAndNoFile) {
  const auto film = filmOf(0, 1);
  EXPECT_EQ(writeShard(path("no/such/folder.exr"), *film, info(0, 1)).code, "IMAGE-WRITE");
  EXPECT_EQ(writeShard(folder_.string(), *film, info(0, 1)).code, "IMAGE-WRITE");
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

}  // namespace
}  // namespace kinora::film
