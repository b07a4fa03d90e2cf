// Every message code in the sources can be explained, and no explanation is empty. The codes are found as string
// literals of capitals with a dash, in files that report messages. Misses: codes that are put together at run time.
#include "app/explanations.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

namespace fs = std::filesystem;

namespace kinora::app {
namespace {

TEST(Explanations, CoverEveryCodeInTheSources) {
  const Explanations all = allExplanations();
  const std::regex code("\"([A-Z]{3,}-[A-Z][A-Z-]+)\"");
  std::set<std::string> found;
  for (const char* top : {"src", "plugins", "include"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(KINORA_SOURCE_DIR) / top)) {
      const std::string name = entry.path().filename().string();
      if (!entry.is_regular_file() || name.find("test") != std::string::npos) continue;
      std::ifstream stream(entry.path());
      std::stringstream text;
      text << stream.rdbuf();
      const std::string source = text.str();
      for (std::sregex_iterator it(source.begin(), source.end(), code), end; it != end; ++it) found.insert((*it)[1]);
    }
  EXPECT_GT(found.size(), 50u);
  for (const std::string& c : found) {
    const Explanation* e = all.find(c);
    ASSERT_NE(e, nullptr) << c << " has no explanation";
    EXPECT_GT(e->text.size(), 20u) << c;
  }
}

TEST(Explanations, ExactCodesComeBeforeFamilies) {
  const Explanations all = allExplanations();
  ASSERT_NE(all.find("image-compare"), nullptr);
  EXPECT_EQ(all.find("image-compare")->code, "IMAGE-COMPARE");
  EXPECT_EQ(all.find("IMAGE-ANYTHING")->code, "IMAGE-");
  EXPECT_EQ(all.find("NOTHING-AT-ALL"), nullptr);
}

}  // namespace
}  // namespace kinora::app
