// Some seconds of the fuzzer with a fixed seed, over files that name every request: a crash that the mutator finds at
// once fails here. Proves nothing about memory errors that do not crash; tests/fuzz/run does, with sanitizers.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "fuzz/rib_input.h"
#include "fuzz/rib_mutator.h"
#include "fuzz/short_run.h"

namespace kinora::fuzz {
namespace {

std::vector<std::string> seeds() {
  std::vector<std::string> found = {"Format 64 64 1\nWorldBegin\nSphere 1 -1 1 360\nWorldEnd\n",
                                    "WorldBegin\nSubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [\"crease\"] [2 1] "
                                    "[0 1] [3] \"P\" [0 0 0 1 0 0 1 1 0 0 1 0]\n"
                                    "NuPatch 4 4 [0 0 0 0 1 1 1 1] 0 1 4 4 [0 0 0 0 1 1 1 1] 0 1 \"P\" [0 0 0 1 0 0 "
                                    "2 0 0 3 0 0 0 1 0 1 1 0 2 1 0 3 1 0 "
                                    "0 2 0 1 2 0 2 2 0 3 2 0 0 3 0 1 3 0 2 3 0 3 3 0]\nWorldEnd\n"};
  for (const auto& e : std::filesystem::directory_iterator(KINORA_SOURCE_DIR "/scenes"))
    if (e.path().extension() == ".rib") {
      std::ifstream in(e.path(), std::ios::binary);
      found.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
  std::sort(found.begin(), found.end());
  return found;
}

TEST(RibFuzz, SomeSecondsWithAFixedSeed) {
  std::vector<std::string> pool = seeds();
  ASSERT_GT(pool.size(), 3u);
  RibMutator random(1);
  const auto [runs, messages] =
      shortRun(random, pool, {}, [](const std::string& rib) { return Outcome{readRibInput(rib)}; });
  EXPECT_GT(runs, 50u);
  EXPECT_GT(messages, runs) << "mutations that nothing is wrong with test nothing";
}

TEST(RibFuzz, InputsOfSeveralFilesAndTheirContainersAreRead) {
  const std::string sphere = "Sphere 1 -1 1 360\n", text = "WorldBegin\nReadArchive \"a\"\nWorldEnd\n";
  EXPECT_EQ(readRibInput(text), 1u) << "the archive is missing";
  EXPECT_EQ(readRibInput(text + "\n##file a\n" + sphere), 0u);
  EXPECT_EQ(readRibInput(gzipped(text) + "\n##file a\n" + gzipped(sphere)), 0u);
  for (bool deflated : {false, true})
    EXPECT_EQ(readRibInput("WorldBegin\nReadArchive \"a.zip!m.rib\"\nWorldEnd\n\n##file a.zip\n" +
                           zipped("m.rib", sphere, deflated)),
              0u);
  std::string plain;
  EXPECT_TRUE(gunzipped(gzipped(text), plain, 1000));
  EXPECT_EQ(plain, text);
  EXPECT_EQ(textOf(tokensOf(text + "\"a\\\"b\" [1 2.5e3]# c\n\200\001")), text + "\"a\\\"b\" [1 2.5e3]# c\n\200\001");
}

}  // namespace
}  // namespace kinora::fuzz
