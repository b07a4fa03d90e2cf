// Reads every RIB file of the shared collection of real scenes. Proves that none of them crashes or hangs the reader
// and that those with a world give one; it does not prove that what was read means what its author meant.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "rib/reader.h"
#include "rib/writer.h"

namespace kinora::rib {
namespace {

namespace fs = std::filesystem;

fs::path sharedFolder() {
  if (const char* given = std::getenv("KINORA_SHARED")) return given;
  for (fs::path start : {fs::current_path(), fs::path(__FILE__).parent_path()})
    for (int up = 0; up < 8 && !start.empty(); ++up, start = start.parent_path())
      for (const char* name : {"shared", "../shared"})
        if (std::error_code e; fs::is_directory(start / name / "scenes", e)) return start / name;
  return {};
}

TEST(RealScenes, AllAreReadWithoutCrashOrHang) {
  const fs::path shared = sharedFolder();
  std::error_code failed;
  if (shared.empty() || !fs::is_directory(shared / "scenes", failed))
    GTEST_SKIP() << "no ../shared/scenes beside the project";
  std::vector<fs::path> files;
  for (const auto& e : fs::recursive_directory_iterator(shared / "scenes"))
    if (e.is_regular_file() && (e.path().extension() == ".rib" || e.path().string().ends_with(".rib.gz")))
      files.push_back(e.path());
  std::sort(files.begin(), files.end());
  ASSERT_FALSE(files.empty());
  std::printf("%-86s %6s %9s %6s %5s %8s %6s\n", "file", "worlds", "primitives", "lights", "kept", "messages", "ms");
  size_t withWorld = 0;
  for (const fs::path& f : files) {
    Diagnostics messages([](const std::string&, Severity) {});
    scene::SceneStatistics all;
    RibReader reader(messages, {}, [&](scene::Scene&& s) {
      const auto one = s.statistics();
      all.primitives += one.primitives;
      all.lights += one.lights;
      all.kept += one.kept;
      EXPECT_FALSE(s.cameras.empty());
      // written and read again it is the same description
      const std::string first = writeRib(s);
      std::string second;
      Diagnostics silent([](const std::string&, Severity) {});
      RibReader again(silent, {}, [&](scene::Scene&& t) { second = writeRib(t); });
      again.readString("again", first);
      again.finish();
      size_t at = 0;
      while (at < first.size() && at < second.size() && first[at] == second[at]) ++at;
      EXPECT_TRUE(first == second) << f << "\nfirst:  ..." << first.substr(at > 200 ? at - 200 : 0, 300)
                                   << "\nsecond: ..."
                                   << (second.empty()
                                           ? ""
                                           : second.substr(std::min(second.size(), at > 200 ? at - 200 : 0), 300));
    });
    const auto start = std::chrono::steady_clock::now();
    reader.readFile(f.string());
    reader.finish();
    const double ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    std::string name = fs::relative(f, shared / "scenes").string();
    if (name.size() > 86) name = "..." + name.substr(name.size() - 83);
    std::printf("%-86s %6zu %9zu %6zu %5zu %8zu %6.1f\n", name.c_str(), reader.worlds(), all.primitives, all.lights,
                all.kept, messages.messages().size(), ms);
    withWorld += reader.worlds() > 0;
    EXPECT_LT(ms, 20000) << f;
    if (std::getenv("KINORA_SHOW_MESSAGES"))
      for (const Message& m : messages.messages()) std::printf("    %s\n", m.str().c_str());
  }
  EXPECT_GT(withWorld, files.size() / 3);
}

}  // namespace
}  // namespace kinora::rib
