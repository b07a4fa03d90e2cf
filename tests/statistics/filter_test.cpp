// Every sample, display, light and pixel filter, every volume and displacement of the registry against the contract of its kind: a
// new plug-in is covered by being there. And the checks catch filters that break it.
#include <gtest/gtest.h>
#include <kinora/channel_filter.h>
#include <kinora/displacement.h>
#include <kinora/testing/filter_checks.h>

#include "tests/statistics/stock_plugins.h"

namespace kinora {
namespace {

class EveryFilter : public ::testing::TestWithParam<const Descriptor*> {};

TEST_P(EveryFilter, KeepsTheContract) {
  const testing::CheckReport report = expectContract([] { return testing::checkFilter(*GetParam()); });
  EXPECT_GT(report.comparisons, 0u);
}
INSTANTIATE_TEST_SUITE_P(Stock, EveryFilter, ::testing::ValuesIn(stockOf(testing::hasFilterChecks)), pluginName);

// A filter that averages its neighbours, and one that divides by zero.
void smear(const void*, const ChannelFilterArgs* a) {
  for (uint32_t i = a->count; i-- > 1;) a->channels[0].data[0][i] += a->channels[0].data[0][i - 1];
}
void burn(const void*, const ChannelFilterArgs* a) {
  for (uint32_t i = 0; i < a->count; ++i) a->channels[0].data[0][i] /= 0.f * float(a->count);
}
constexpr ChannelFilterTraits kTraits{[](const void*, uint32_t i) -> const char* { return i == 0 ? "Ci" : nullptr; }};
const SampleFilterFunctions kSmear{&smear}, kBurn{&burn};

testing::CheckReport check(const SampleFilterFunctions& f) {
  const WidthTable tables[] = {{1, &f}};
  static int nothing;
  const Descriptor d{kAbiVersion,
                     sizeof(Descriptor),
                     Kind::SampleFilter,
                     0,
                     "broken",
                     "",
                     nullptr,
                     0,
                     tables,
                     1,
                     &kTraits,
                     [](const CreateInfo*, ErrorText*) -> void* { return &nothing; },
                     [](void*) {}};
  return testing::checkFilter(d);
}

TEST(FilterChecks, CatchBrokenFilters) {
  EXPECT_TRUE(check(kSmear).failed("neighbours"));
  EXPECT_TRUE(check(kBurn).failed("finite"));
}

// A displacement that follows its neighbour, and one that goes farther than it says.
void follow(const Context* c, float* const offset[3]) {
  for (uint32_t i = 0; i < c->padded; ++i)
    for (int k = 0; k < 3; ++k) offset[k][i] = i ? c->P[k][i - 1] : 0.f;
}
void overreach(const Context* c, float* const offset[3]) {
  for (uint32_t i = 0; i < c->padded; ++i)
    for (int k = 0; k < 3; ++k) offset[k][i] = c->N[k][i];
}

TEST(FilterChecks, CatchBrokenDisplacements) {
  const auto check = [](const DisplacementFunctions& f) {
    const WidthTable tables[] = {{1, &f}};
    static constexpr DisplacementTraits kTraits{[](const CreateInfo*) { return 0.5f; }};
    Descriptor d{};
    d.abiVersion = kAbiVersion;
    d.descriptorBytes = sizeof(Descriptor);
    d.kind = Kind::Displacement;
    d.name = "broken";
    d.doc = "";
    d.tables = tables;
    d.tableCount = 1;
    d.traits = &kTraits;
    return testing::checkFilter(d);
  };
  EXPECT_TRUE(check({&follow}).failed("neighbours"));
  EXPECT_TRUE(check({&overreach}).failed("bound"));
}

}  // namespace
}  // namespace kinora
