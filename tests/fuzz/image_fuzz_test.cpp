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
  EXPECT_GT(runs, 50u);
  EXPECT_GT(refused, runs / 10) << "mutations that break nothing test nothing";
  EXPECT_LT(refused, runs) << "mutations that break everything reach nothing";
}

}  // namespace
}  // namespace kinora::fuzz
