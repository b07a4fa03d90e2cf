// Some seconds of broken and cut pictures of each format with a fixed seed, through the picture reader and the
// texture lookups. Proves that what is broken is refused or read, without a crash; memory errors that do not crash
// are tests/fuzz/run's.
#include <gtest/gtest.h>

#include <ctime>

#include "fuzz/image_input.h"
#include "fuzz/image_mutator.h"

namespace kinora::fuzz {
namespace {

// Silence is right only where the finest level, which is what a reader gets, is all there.
void expectCutIsToldOrHarmless(const std::string& name, std::string_view bytes, size_t part,
                               const ImageOutcome& whole) {
  const ImageOutcome cut = loadImageInput(bytes.substr(0, part));
  EXPECT_TRUE(!cut.words.empty() || (cut.read && cut.isTexture && cut.sum == whole.sum))
      << name << " cut at " << part;
}

TEST(ImageFuzz, WholeFilesAreReadAndCutOnesAreNoCrash) {
  const auto images = smallImages();
  ASSERT_GE(images.size(), 26u);
  for (const auto& [name, bytes] : images) {
    const ImageOutcome whole = loadImageInput(bytes);
    EXPECT_TRUE(whole.read) << name << ": " << whole.words;
    EXPECT_TRUE(whole.isTexture) << name << ": " << whole.words;
    for (size_t part : {size_t(0), size_t(3), bytes.size() / 4, bytes.size() / 2})
      expectCutIsToldOrHarmless(name, bytes, part, whole);
    // a cut between two levels of a pyramid leaves a smaller pyramid; where the levels end depends on the
    // compressor of the machine, so cuts are made everywhere
    if (name.ends_with("mip.tx"))
      for (size_t part = 8; part < bytes.size(); part += 31) expectCutIsToldOrHarmless(name, bytes, part, whole);
  }
}

// Findings: OpenImageIO's reader never ended on such strips, or aborted the program when its messages filled 16 MB; a
// tile was allocated whole.
TEST(ImageFuzz, StripsAndTilesOfBillionsOfRowsAreRefused) {
  const auto tiff = [](uint32_t rowsPerStrip, uint32_t tileRows = 0) {
    std::string out("MM\0*", 4);
    const auto put = [&](uint64_t v, int bytes) {
      while (bytes--) out += char(v >> (8 * bytes) & 255);
    };
    constexpr uint32_t kStrips = 20, kData = 64, kBits = 8 + kData + 8 * kStrips;
    put(kBits + 6, 4);
    for (uint32_t i = 0; i < kData / 4; ++i) put(0x80ff1234u, 4);
    for (uint32_t i = 0; i < kStrips; ++i) put(8, 4);
    for (uint32_t i = 0; i < kStrips; ++i) put(kData, 4);
    for (int i = 0; i < 3; ++i) put(8, 2);
    put(tileRows ? 11 : 10, 2);
    const auto entry = [&](uint32_t tag, uint32_t type, uint32_t count, uint32_t value) {
      put(tag, 2), put(type, 2), put(count, 4);
      const bool isShort = type == 3 && count == 1;
      put(value, isShort ? 2 : 4), put(0, isShort ? 2 : 0);
    };
    entry(256, 3, 1, 256), entry(257, 3, 1, 1000), entry(258, 3, 3, kBits), entry(259, 3, 1, 5);
    if (!tileRows) entry(273, 4, kStrips, 8 + kData);
    entry(277, 3, 1, 3);
    if (!tileRows) entry(278, 4, 1, rowsPerStrip), entry(279, 4, kStrips, 8 + kData + 4 * kStrips);
    entry(284, 3, 1, 1), entry(317, 3, 1, 2);
    if (tileRows) {
      entry(322, 3, 1, 64), entry(323, 4, 1, tileRows);
      entry(324, 4, kStrips, 8 + kData), entry(325, 4, kStrips, 8 + kData + 4 * kStrips);
    }
    put(0, 4);
    return out;
  };
  for (uint32_t rows : {0x7fffffffu, 0x80000000u, 0x90000000u, 0x10000001u}) {
    const ImageOutcome outcome = loadImageInput(tiff(rows));
    EXPECT_FALSE(outcome.read);
    EXPECT_FALSE(outcome.isTexture);
    EXPECT_FALSE(outcome.words.empty());
    if (rows < 0x80000000u) {
      EXPECT_NE(outcome.words.find("strips"), std::string::npos) << outcome.words;
    }
  }
  const ImageOutcome tiled = loadImageInput(tiff(0, 4194304));
  EXPECT_NE(tiled.words.find("strips or tiles"), std::string::npos) << tiled.words;
  EXPECT_EQ(loadImageInput(tiff(0, 64)).words.find("strips or tiles"), std::string::npos);
  EXPECT_EQ(loadImageInput(tiff(0xffffffffu)).words.find("strips"), std::string::npos) << "one strip is common";
}

// Where the entries of a TIFF's directories begin, one list for each of its levels.
std::vector<std::vector<size_t>> directories(std::string_view bytes) {
  std::vector<std::vector<size_t>> found;
  if (!bytes.starts_with(std::string_view("II*\0", 4))) return found;
  const auto number = [&](size_t at, int size) {
    size_t v = 0;
    for (int i = size; i-- > 0;) v = v << 8 | static_cast<unsigned char>(bytes[at + i]);
    return v;
  };
  for (size_t at = number(4, 4); at && at + 6 < bytes.size();) {
    const size_t entries = number(at, 2), next = at + 2 + entries * 12;
    if (next + 4 > bytes.size()) break;
    for (found.emplace_back(); at + 2 + found.back().size() * 12 < next;)
      found.back().push_back(at + 2 + found.back().size() * 12);
    at = number(next, 4);
  }
  return found;
}
void putNumber(std::string& bytes, size_t at, uint32_t value, int size) {
  for (int i = 0; i < size; ++i) bytes[at + i] = char(value >> (8 * i) & 255);
}
constexpr uint32_t kExtremes[] = {0, 0x7fffffff, 0xffffffff};

// Findings: tiles of 2^32 - 1 columns or rows came as -1 and were divided by (SIGFPE), in the first level or in another;
// tiles of a coarser level that are 2^31 deep were allocated.
TEST(ImageFuzz, NumbersOfTiffDirectoriesMayBeAnything) {
  size_t runs = 0, refused = 0;
  const auto load = [&](const std::string& bytes) {
    refused += !loadImageInput(bytes).read;
    ++runs;
  };
  for (const auto& [name, whole] : smallImages())
    for (const auto& entries : directories(whole)) {
      SCOPED_TRACE(name);
      std::string bytes = whole;
      for (size_t entry : entries)
        for (size_t part : {size_t(4), size_t(8)})  // count and value
          for (uint32_t value : kExtremes) {
            bytes.replace(entry, 12, whole, entry, 12);
            putNumber(bytes, entry + part, value, 4);
            load(bytes);
          }
      // entries that the file did not have, in place of its last: rows a strip, a tile's sides and depth
      const size_t last = entries.back();
      bytes = whole;
      for (uint32_t tag : {278u, 322u, 323u, 32998u})
        for (uint32_t value : kExtremes) {
          putNumber(bytes, last, tag, 2), putNumber(bytes, last + 2, 4, 2);
          putNumber(bytes, last + 4, 1, 4), putNumber(bytes, last + 8, value, 4);
          load(bytes);
        }
    }
  EXPECT_GT(runs, 300u);
  EXPECT_GT(refused, runs / 20);
  EXPECT_LT(refused, runs);
}

TEST(ImageFuzz, SomeSecondsWithAFixedSeed) {
  const auto images = smallImages();
  ImageMutator random(1);
  const std::clock_t end = std::clock() + 3 * CLOCKS_PER_SEC;
  size_t runs = 0, refused = 0;
  for (; runs < 3000 && std::clock() < end; ++runs) {
    const std::string& a = images[random.below(images.size())].second;
    const std::string& b = images[random.below(images.size())].second;
    refused += !loadImageInput(random.mutate(a, b, 100000)).read;
  }
  EXPECT_GT(runs, 20u);
  EXPECT_GT(refused, runs / 10) << "mutations that break nothing test nothing";
  EXPECT_LT(refused, runs) << "mutations that break everything reach nothing";
}

}  // namespace
}  // namespace kinora::fuzz
