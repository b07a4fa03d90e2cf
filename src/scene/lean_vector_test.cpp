#include "scene/lean_vector.h"

#include <gtest/gtest.h>

#include <string>

namespace kinora::scene {
namespace {

TEST(LeanVector, TakesAPointerWhileItIsEmpty) {
  LeanVector<int> v;
  EXPECT_EQ(sizeof v, sizeof(void*));
  EXPECT_EQ(v.bytes(), 0u);
  EXPECT_TRUE(v.empty());
  EXPECT_EQ(v.size(), 0u);
  EXPECT_EQ(v.begin(), v.end());
  EXPECT_EQ(std::as_const(v).begin(), std::as_const(v).end());
  EXPECT_EQ(v.get(), std::vector<int>());
  v = {1, 2, 3};
  EXPECT_GE(v.bytes(), sizeof(std::vector<int>) + 3 * sizeof(int));
  v.clear();
  EXPECT_EQ(v.bytes(), 0u);
  v = std::vector<int>();
  EXPECT_EQ(v.bytes(), 0u);
  v.resize(2);
  v.resize(0);
  EXPECT_EQ(v.bytes(), 0u);
}

TEST(LeanVector, CopiesAreTheirOwn) {
  LeanVector<std::string> a{"x", "y"};
  LeanVector<std::string> b = a;
  b[0] = "z";
  b.push_back("w");
  EXPECT_EQ(a, (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(b, (std::vector<std::string>{"z", "y", "w"}));
  EXPECT_FALSE(a == b);
  a = b;
  EXPECT_EQ(a, b);
  a.pop_back();
  EXPECT_EQ(a.size(), 2u);
  EXPECT_EQ(b.back(), "w");
  b = std::move(a);
  EXPECT_EQ(b, (std::vector<std::string>{"z", "y"}));
  b.assign(2, "v");
  EXPECT_EQ(b, (std::vector<std::string>{"v", "v"}));
  // what was emptied by hand is what was never filled
  b.edit().clear();
  EXPECT_EQ(b, LeanVector<std::string>());
}

}  // namespace
}  // namespace kinora::scene
