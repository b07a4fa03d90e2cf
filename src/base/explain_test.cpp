// The registry behind `kinora explain`.
#include "base/explain.h"

#include <gtest/gtest.h>

namespace kinora {
namespace {

TEST(Explanations, ExactBeforeFamilyAndWithoutCase) {
  static constexpr Explanation kOne[] = {{"A-ONE", "first"}, {"A-KEPT-", "family"}, {"A-", "all"}};
  static constexpr Explanation kTwo[] = {{"A-KEPT-X", "special"}};
  Explanations all;
  all.add(kOne);
  all.add(kTwo);
  EXPECT_EQ(all.find("a-one")->text, "first");
  EXPECT_EQ(all.find("A-KEPT-FOO")->text, "family");
  EXPECT_EQ(all.find("A-KEPT-X")->text, "special");
  EXPECT_EQ(all.find("A-ON")->text, "all");  // the longest family
  EXPECT_EQ(all.find("B-ON"), nullptr);
  EXPECT_EQ(all.find(""), nullptr);
  EXPECT_EQ(all.codes().size(), 4u);
  EXPECT_EQ(all.codes()[0], "A-");
}

}  // namespace
}  // namespace kinora
