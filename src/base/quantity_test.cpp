#include "base/quantity.h"

#include <gtest/gtest.h>

namespace kinora {
namespace {

TEST(Quantity, SizesArePowersOf1024) {
  EXPECT_EQ(parseSize("123"), 123u);
  EXPECT_EQ(parseSize("100k"), 102400u);
  EXPECT_EQ(parseSize("1.5G"), uint64_t(3) << 29);
  for (const char* same : {"4M", "4m", "4MB", "4MiB", "4mib"}) EXPECT_EQ(parseSize(same), uint64_t(4) << 20) << same;
  for (const char* none : {"", "G", "-1G", "4X", "4MM", "1e30", "nan", "inf", "4 M", "0"})
    EXPECT_EQ(parseSize(none), 0u) << none;
}

TEST(Quantity, TimesAreSeconds) {
  for (const auto& [text, seconds] :
       {std::pair("90", 90.0), {"90s", 90}, {"5m", 300}, {"5min", 300}, {"1.5h", 5400}, {"2D", 172800}, {"0", 0}})
    EXPECT_EQ(parseTime(text), seconds) << text;
  for (const char* none : {"", "s", "-5s", "5x", "16i", "nan", "1e10", "5 m"}) EXPECT_FALSE(parseTime(none)) << none;
}

}  // namespace
}  // namespace kinora
