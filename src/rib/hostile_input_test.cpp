// Input made to hurt: floods of brackets of a gigabyte, devices named as archives. Proves bounded memory and time;
// what the fuzzer found is here too, as the smallest file that shows it.
#include <sys/resource.h>
#include <unistd.h>
#include <zlib.h>

#include <ctime>
#include <filesystem>
#include <fstream>

#include "rib/test_support.h"

namespace kinora::rib {
namespace {

long peakKilobytes() {
  rusage use{};
  getrusage(RUSAGE_SELF, &use);
  return use.ru_maxrss;
}

// A gzip file of `head`, then `count` times 16 MB of `filler`: gzip files one after the other are one.
std::string bomb(const std::string& name, const std::string& head, char filler, int count) {
  const std::string path =
      (std::filesystem::temp_directory_path() / (name + std::to_string(getpid()) + ".gz")).string();
  const auto member = [&](const std::string& text) {
    gzFile z = gzopen((path + ".part").c_str(), "wb1");
    gzwrite(z, text.data(), unsigned(text.size()));
    gzclose(z);
    std::ifstream in(path + ".part", std::ios::binary);
    return std::string{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  };
  std::ofstream out(path, std::ios::binary);
  out << member(head);
  const std::string flood = member(std::string(16 << 20, filler));
  for (int i = 0; i < count; ++i) out << flood;
  std::filesystem::remove(path + ".part");
  return path;
}

struct Flood {
  const char *name, *head, *code;
  char filler;
};
class Floods : public testing::TestWithParam<Flood> {};

TEST_P(Floods, OfAGigabyteAreReadInBoundedMemoryAndTime) {
  const Flood& f = GetParam();
  const std::string path = bomb(f.name, f.head, f.filler, 64);
  const long before = peakKilobytes();
  const std::clock_t start = std::clock();
  Diagnostics messages([](const std::string&, Severity) {});
  RibReader reader(messages, {}, [](scene::Scene&&) {});
  reader.readFile(path);
  reader.finish();
  std::filesystem::remove(path);
  EXPECT_GE(reader.bytesRead(), uint64_t(1) << 30);
  EXPECT_LT(peakKilobytes() - before, 200000);
  EXPECT_LT(double(std::clock() - start) / CLOCKS_PER_SEC, 60) << "CPU seconds";
  EXPECT_EQ(messages.count(f.code), 1u);
  EXPECT_LT(messages.messages().size(), 8u) << "one for each block that the flood leaves open";
}

INSTANTIATE_TEST_SUITE_P(All, Floods,
                         testing::Values(Flood{"BracketsFirst", "", "RIB-SYNTAX", '['},
                                         Flood{"BracketsInARequest", "WorldBegin\nPolygon \"P\" ", "RIB-ARRAY", '['},
                                         Flood{"ClosingBrackets", "WorldBegin\nPolygon \"P\" ", "RIB-BRACKET", ']'}),
                         [](const auto& info) { return info.param.name; });

TEST(HostileInput, DevicesAreNoArchives) {
  for (const char* name : {"/dev/zero", "/dev/stdin", "/dev/zero!a.rib"}) {
    const Read r = readWorld(std::string("ReadArchive \"") + name + "\"\nSphere 1 -1 1 360");
    expectMessage(r, "ASSET-MISSING-ARCHIVE", 2);
    EXPECT_EQ(r.world().primitives.size(), 1u);
  }
}

// Each object has the keys of all motion around it: those are bounded, or 300 requests would have millions.
TEST(Hostile, MotionInMotionHasBoundedKeys) {
  std::string text = "WorldBegin\n";
  for (int i = 0; i < 300; ++i)
    text += "AttributeBegin\nMotionBegin [" + std::to_string(i * 0.001) + " " + std::to_string(0.5 + i * 0.001) +
            "]\nRotate " + std::to_string(i) + " 0 0 1\nRotate 1 0 0 1\nMotionEnd\nSphere 1 -1 1 360\n";
  const Read r = readRib(text);
  ASSERT_EQ(r.world().primitives.size(), 300u);
  size_t keys = 0, most = 0;
  for (const auto& p : r.world().primitives) {
    keys += p->toWorld.matrices.size();
    most = std::max(most, p->toWorld.matrices.size());
  }
  EXPECT_EQ(most, scene::Transform::kMostKeys);
  EXPECT_LE(keys, 300 * scene::Transform::kMostKeys);
  EXPECT_NE(r.all().find("more than 1024 keys"), std::string::npos) << "it is told";
  // and those of one that turns very often
  const Read turns = readWorld("MotionBegin [0 1]\nRotate 0 0 0 1\nRotate 1e6 0 0 1\nMotionEnd\nSphere 1 -1 1 360\n");
  EXPECT_EQ(turns.world().primitives[0]->toWorld.matrices.size(), scene::Transform::kMostKeys);
}

}  // namespace
}  // namespace kinora::rib
