// The raised cosine's values and integral, through the descriptor as the renderer uses it.
#include <gtest/gtest.h>
#include <kinora/pixel_filter.h>

#include <cstring>

#include "plugin/registry.h"

namespace kinora {
namespace {

TEST(Hann, IsARaisedCosineOverTheWidths) {
  const Descriptor* d = nullptr;
  for (const Descriptor* k : stockPlugins())
    if (!std::strcmp(k->name, "hann")) d = k;
  ASSERT_TRUE(d && d->kind == Kind::PixelFilter);
  const PixelFilterInfo size{{3, 5}};
  CreateInfo info{};
  info.extra = &size;
  ErrorText error{};
  void* f = d->create(&info, &error);
  ASSERT_TRUE(f);
  const auto* fn = static_cast<const PixelFilterFunctions*>(d->tables[0].functions);
  EXPECT_DOUBLE_EQ(fn->value(f, 0, 0), 1);
  EXPECT_NEAR(fn->value(f, 0.75, 0), 0.5, 1e-12);
  EXPECT_NEAR(fn->value(f, 0.75, -1.25), 0.25, 1e-12);
  EXPECT_EQ(fn->value(f, 1.5, 0), 0);
  EXPECT_EQ(fn->value(f, 0, 7), 0);
  double sum = 0;
  constexpr int n = 200;  // the midpoint rule is exact for a cosine over its period
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      sum += fn->value(f, 3 * ((i + 0.5) / n - 0.5), 5 * ((j + 0.5) / n - 0.5)) * 15 / (n * n);
  EXPECT_NEAR(sum, 15 / 4.0, 1e-9);
  d->destroy(f);
}

}  // namespace
}  // namespace kinora
